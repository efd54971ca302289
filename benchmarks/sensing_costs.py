"""What an estimate of one 1080p pair costs, in ratios: to single passes of OpenCV's, and to the paper's steps written plainly."""

import time
from collections.abc import Callable, Iterator, Mapping

import cv2

from benchmarks import plain_steps
from benchmarks.degradations.coding import jpeg
from benchmarks.degradations.scenery import REFERENCE
from benchmarks.poses import LENGTH_MM, NODES_MM, bent, centreline, photograph, renderers
from benchmarks.timing import medians_s
from benchmarks.yardstick import least_ratio, most_ratio
from sensing.method import METHODS, Method
from sensing.refined.track import Track
from sensing.scene import Scene
from sensing.settings import MethodName
from sensing.shape import Shape

REPEATS, PLAIN_REPEATS = 30, 3
DARK_BGR = (0, 0, 0), (90, 90, 90)
POSE, POSE_BEFORE = bent((0.5, 0.8), (0.3, 0.9)), bent((0.49, 0.78), (0.3, 0.9))
"""A tip that moves by about 1 mm from one frame to the next."""

Pictures = Mapping[str, bytes]


def estimated(method: Method, jpegs: Pictures, last: Track | None = None) -> Shape:
    """The shape in coded pictures by camera; raises as `Method.estimate` does."""
    pictures = {name: method.scene.picture(name, data) for name, data in jpegs.items()}
    return method.estimate(pictures, 0.0, last, time.perf_counter)


def cost_lines() -> Iterator[str]:
    """Every cost as a line: the yardstick, what was measured, met or missed."""
    cameras = renderers(REFERENCE.rig)
    before, marked = (photograph(cameras, centreline(pose)) for pose in (POSE_BEFORE, POSE))
    decoded = {name: plain_steps.decoded(data) for name, data in marked.items()}
    encode = jpeg()
    unmarked = {name: encode(picture) for name, picture in decoded.items()}
    empty = REFERENCE.studio.empty
    scene = Scene.of(
        REFERENCE.rig,
        backgrounds={name: encode(picture) for name, picture in empty.items()},
        length_mm=LENGTH_MM,
    )
    refined, plain = (METHODS[name](scene) for name in (MethodName.REFINED, MethodName.PLAIN))
    track = estimated(refined, before).track
    yield from _beside_opencv(refined, track, marked, unmarked)
    yield from _beside_plain_steps(refined, plain, track, marked, empty)


def _beside_opencv(
    refined: Method, track: Track | None, marked: Pictures, unmarked: Pictures
) -> Iterator[str]:
    pictures = {name: refined.scene.picture(name, data) for name, data in marked.items()}
    frames = [picture.colour for picture in pictures.values()]
    for picture in pictures.values():
        _ = picture.luma
    works: dict[str, Callable[[], object]] = {
        "decoded": lambda: refined.estimate(pictures, 0.0, track, time.perf_counter),
        "pass": lambda: [cv2.inRange(frame, *DARK_BGR) for frame in frames],
    }
    times = medians_s(works, REPEATS)
    yield most_ratio(
        "decoded frames to nodal points, warm", times["decoded"], 1.0, times["pass"], "one cv2.inRange"
    )
    for kind, jpegs in (("with restart markers", marked), ("without restart markers", unmarked)):
        works = {
            "bytes": lambda jpegs=jpegs: estimated(refined, jpegs, track),
            "decode": lambda jpegs=jpegs: [plain_steps.decoded(data) for data in jpegs.values()],
        }
        times = medians_s(works, REPEATS)
        yield most_ratio(
            f"JPEG bytes {kind} to nodal points, warm", times["bytes"], 1.5, times["decode"], "decoding them"
        )


def _beside_plain_steps(
    refined: Method,
    plain: Method,
    track: Track | None,
    jpegs: Pictures,
    empty: Mapping[str, plain_steps.Image],
) -> Iterator[str]:
    def plainly() -> object:
        pictures = {name: plain_steps.decoded(data) for name, data in jpegs.items()}
        return plain_steps.nodal_points(pictures, empty, REFERENCE.rig, NODES_MM)

    baseline_s = medians_s({"plainly": plainly}, PLAIN_REPEATS)["plainly"]
    works: dict[str, Callable[[], object]] = {
        "refined, warm": lambda: estimated(refined, jpegs, track),
        "refined, cold": lambda: estimated(refined, jpegs),
        "sensing/plain": lambda: estimated(plain, jpegs),
    }
    for name, taken_s in medians_s(works, REPEATS // 3).items():
        yield least_ratio(name, taken_s, 20.0, baseline_s, "the paper's steps with NumPy and scikit-image")
