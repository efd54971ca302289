"""Pictures of boards and of the robot in, cameras and their quality out: pure functions. `nodal calibrate` runs them."""
