"""Cases of light, lens, sensor and coding."""

import cv2

from benchmarks.degradations import coding, optics
from benchmarks.degradations.level import Case, Level
from benchmarks.degradations.motions import anywhere
from benchmarks.degradations.scenery import Bench
from drivers.simulated.cameras.settings import LightSettings

_FAST = anywhere(fastest_rad_s=4.0)

PICTURE_CASES = (
    Case("noise", tuple(Level(name=f"{sigma:g} levels", noise_levels=sigma) for sigma in (4.0, 8.0, 16.0))),
    Case(
        "blur", tuple(Level(name=f"{sigma:g} px", optics=optics.blurred(sigma)) for sigma in (1.5, 3.0, 6.0))
    ),
    Case(
        "motion blur",
        tuple(
            Level(name=f"{1e3 * exposure_s:g} ms, fast", motion=_FAST, exposure_s=exposure_s)
            for exposure_s in (0.006, 0.015)
        ),
    ),
    Case(
        "jpeg quality",
        tuple(Level(name=f"{quality}", coder=coding.jpeg(quality)) for quality in (95, 60, 30)),
    ),
    Case(
        "coding",
        (
            Level(name="4:2:2", coder=coding.jpeg(sampling=cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422)),
            Level(name="4:4:4", coder=coding.jpeg(sampling=cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444)),
            Level(name="progressive", coder=coding.jpeg(progressive=True)),
            Level(name="grey", coder=coding.grey_jpeg),
            Level(name="16-bit PNG", coder=coding.png_16_bit),
        ),
    ),
    Case(
        "exposure", tuple(Level(name=f"{stops:+g} stop", optics=optics.exposed(stops)) for stops in (1, -1))
    ),
    Case(
        "low light",
        (
            Level(name="-1.7 stops, noise 4", optics=optics.exposed(-1.7), noise_levels=4.0),
            Level(name="-3 stops, noise 6", optics=optics.exposed(-3), noise_levels=6.0),
        ),
    ),
    Case("gradient", tuple(Level(name=f"to {share:g}", optics=optics.uneven(share)) for share in (0.6, 0.3))),
    Case(
        "shadow",
        tuple(Level(name=f"{depth:.0%} deep", optics=optics.shadow(depth)) for depth in (0.2, 0.4, 0.6)),
    ),
    Case(
        "dust", tuple(Level(name=f"{specks} specks", optics=optics.dusty(specks)) for specks in (100, 1000))
    ),
    Case(
        "glare",
        (
            Level(name="beside the robot", optics=optics.glare(50, 12)),
            Level(name="on the robot", optics=optics.glare(50)),
            Level(name="on the tip", optics=optics.glare(80)),
        ),
    ),
    Case(
        "backdrop",
        tuple(
            Level(name=name, bench=Bench(light=LightSettings(backdrop_colour=colour)))
            for name, colour in (
                ("blue", (60, 90, 160)),
                ("white", (225, 225, 225)),
                ("grey", (150, 150, 150)),
                ("black", (25, 25, 25)),
                ("like the robot", (100, 104, 116)),
            )
        ),
    ),
    Case(
        "background picture",
        (
            Level(name="true", background=optics.untouched),
            Level(name="0.3 stops brighter", background=optics.exposed(0.3)),
            Level(name="0.3 stops darker", background=optics.exposed(-0.3)),
            Level(name="camera moved by 8 px", background=optics.shifted(8)),
        ),
    ),
)
