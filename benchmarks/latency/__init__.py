"""From a picture's capture to the command that it led to, in the real processes."""
