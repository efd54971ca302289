"""Sensing on the simulated cameras: `python benchmarks/shape_sensing.py [--poses 40]`.

Accuracy over seeded poses against the renderer's truth, cold and warm, and the cost of a warm estimate as ratios to
what OpenCV takes for single passes over the same frames, measured in the same run on one thread.
"""

import argparse
import time
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from drivers.simulated.cameras.renderer import Renderer
from drivers.simulated.cameras.rig import default_cameras
from drivers.simulated.cameras.settings import SimulatedCamerasSettings
from sensing.errors import SensingError
from sensing.refined.method import Refined
from sensing.scene import Scene
from sensing.shape import Shape

SECTION_MM = 40.0
NODES_MM = np.arange(10.0, 81.0, 10.0)
REPEATS = 30


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=40)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    rig = default_cameras()
    section_ends = np.array([SECTION_MM, 2 * SECTION_MM])
    renderers = [
        Renderer(camera, section_ends, SimulatedCamerasSettings(), seed) for seed, camera in enumerate(rig)
    ]
    scene = Scene.of(rig, length_mm=2 * SECTION_MM)
    random = np.random.default_rng(1)
    cold, warm, flagged, refused = [], [], 0, 0
    for _ in range(arguments.poses):
        truth = _two_arcs(random.uniform(0, 1.3, 2), random.uniform(-np.pi, np.pi, 2))
        frames = {
            camera.camera: renderer.render(truth, truth)
            for camera, renderer in zip(rig, renderers, strict=True)
        }
        try:
            shape = _estimate(scene, frames, None)
        except SensingError as error:
            refused += 1
            print(f"refused: {error}")
            continue
        flagged += bool(shape.flags)
        cold.append(_errors(shape, truth))
        warm.append(_errors(_estimate(scene, frames, shape), truth))
    print(
        f"{arguments.poses} poses, {refused} refused, {flagged} flagged; node error in mm, 10 to 80 mm from the base"
    )
    for name, errors in (("cold", np.array(cold)), ("warm", np.array(warm))):
        print(
            f"  {name}: mean {errors.mean():.4f}  p95 {np.percentile(errors, 95):.4f}  max {errors.max():.4f}  "
            f"tip mean {errors[:, -1].mean():.4f}"
        )
    _costs(scene, frames, shape)


def _costs(scene: Scene, frames: dict[str, bytes], last: Shape) -> None:
    data = [np.frombuffer(jpeg, np.uint8) for jpeg in frames.values()]
    colours = [cv2.imdecode(jpeg, cv2.IMREAD_COLOR) for jpeg in data]
    whole = _median_ms(lambda: _estimate(scene, frames, last))
    decoded = {name: scene.picture(name, jpeg) for name, jpeg in frames.items()}
    for picture in decoded.values():
        _ = picture.luma
    after_decoding = _median_ms(lambda: Refined(scene).estimate(decoded, 0.0, last.track, time.perf_counter))
    in_range = _median_ms(lambda: [cv2.inRange(colour, (0, 0, 0), (90, 90, 90)) for colour in colours])
    decode = _median_ms(lambda: [cv2.imdecode(jpeg, cv2.IMREAD_COLOR) for jpeg in data])
    print("warm estimate of one 1080p pair, medians on one thread")
    print(
        f"  decoded frames to nodal points {after_decoding:6.2f} ms = {after_decoding / in_range:.2f} x cv2.inRange over both"
    )
    print(
        f"  JPEG bytes to nodal points     {whole:6.2f} ms = {whole / decode:.2f} x decoding both in colour"
    )


def _estimate(scene: Scene, frames: dict[str, bytes], last: Shape | None) -> Shape:
    pictures = {name: scene.picture(name, jpeg) for name, jpeg in frames.items()}
    return Refined(scene).estimate(pictures, 0.0, None if last is None else last.track, time.perf_counter)


def _errors(shape: Shape, truth: NDArray[np.float64]) -> NDArray[np.float64]:
    nodes_mm, _ = shape.nodes(NODES_MM)
    return np.linalg.norm(nodes_mm - truth[NODES_MM.astype(int)], axis=1)


def _two_arcs(bend_rad: NDArray[np.float64], azimuth_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centreline (81, 3) in mm of two circular arcs, a point every millimetre."""
    fine = 100
    step_mm = 1.0 / fine
    points, frame = [np.zeros(3)], np.eye(3)
    for bend, azimuth in zip(bend_rad, azimuth_rad, strict=True):
        turn = bend / (SECTION_MM * fine) * np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        rotation = Rotation.from_rotvec(turn).as_matrix()
        for _ in range(int(SECTION_MM) * fine):
            points.append(points[-1] + step_mm * frame[:, 2])
            frame = frame @ rotation
    return np.array(points[::fine])


def _median_ms(work: Callable[[], object]) -> float:
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


if __name__ == "__main__":
    main()
