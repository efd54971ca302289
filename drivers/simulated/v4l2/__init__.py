"""Webcams that stand in for real ones below the V4L2 calls, so that drivers run on them unmodified.

`description` says what a camera offers (a Logitech C922 unless told otherwise), `scene` what it sees with its focus, exposure and
gain, `exposing` makes frames out of pictures, `formats` and `controls` answer its ioctls with the kernel's own structs, `camera`
is the whole device, `plugging` puts devices where programs look for them.
"""

from drivers.simulated.v4l2.camera import StandInCamera
from drivers.simulated.v4l2.plugging import plugged_in
from drivers.simulated.v4l2.scene import Scene

__all__ = ["Scene", "StandInCamera", "plugged_in"]
