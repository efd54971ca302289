"""The report of a recording: figures in summary.json, and pictures in the manner of the paper's figures 3, 4 and 6."""
