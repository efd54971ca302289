"""Recordings: the MCAP writer, the reader, and the process that logs a bench's topics."""
