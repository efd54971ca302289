"""Webcams that stand in for real ones below the V4L2 calls, so that drivers run on them unmodified.

`description` says what a camera offers (a Logitech C922 unless told otherwise), `exposing` makes frames out of pictures,
`calls` answers its ioctls with the kernel's own structs, `camera` is the whole device, `plugging` puts devices where
programs look for them.
"""

from drivers.simulated.v4l2.camera import StandInCamera
from drivers.simulated.v4l2.plugging import plugged_in

__all__ = ["StandInCamera", "plugged_in"]
