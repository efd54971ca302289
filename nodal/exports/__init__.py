"""What a recording is exported to: tables (CSV, NPZ, Parquet), pictures, attached files, a video, and plots for a paper."""
