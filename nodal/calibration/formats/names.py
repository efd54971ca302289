"""What the formats are called. Imports nothing, so that help stays quick."""

RIG, CAMERAS = "rig", "cameras"
OPENCV, ROS, KALIBR, MATLAB = "opencv", "ros", "kalibr", "matlab"
FORMATS = (RIG, CAMERAS, OPENCV, ROS, KALIBR, MATLAB)

UNITS_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
