"""The calibration report: one HTML page of what lies in the folder of the calibration."""

SECTIONS = (
    "cameras",
    "accuracy",
    "space",
    "base",
    "background",
    "robot",
    "coverage",
    "residuals",
    "distortion",
    "views",
)
"""Each is a file of this folder with TITLE and `content(material)`, which returns None when it has nothing to show."""
