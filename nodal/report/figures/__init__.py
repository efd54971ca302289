"""A run's figures: the same for the page, for `--json` and for the comparison of several runs."""
