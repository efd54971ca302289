"""Live replay: a recording goes back onto the bus, with its own spacing, as if it were new."""
