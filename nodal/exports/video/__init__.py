"""A recording as a film: the cameras side by side in real time, with what sensing and the controller made of them."""
