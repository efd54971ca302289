"""Calibrations in files: this project's own, and those of other tools; one module a format."""
