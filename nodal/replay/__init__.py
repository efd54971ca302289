"""Replay: sensing and the controller run over a log again, through the very functions that ran live, and compared."""
