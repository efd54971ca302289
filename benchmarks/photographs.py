"""Sensing on photographs with exact truth: `python benchmarks/photographs.py [FOLDER] [--no-background] [--length MM]`.

FOLDER holds calibration.json, pairs/, truth/, sequence/ and background/, laid out as README.md beside them says. Every
pair is estimated from nothing (no prior). Prints a line for each and the figures over all.
"""

import argparse
import json
import time
from pathlib import Path

import cv2
import numpy as np

from nodal.calibration_file import rig_from_matrices
from sensing.errors import SensingError
from sensing.refined.method import Refined
from sensing.scene import Scene


def main() -> None:
    """Estimate every pair in the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, help="without one there is nothing to measure")
    parser.add_argument(
        "--no-background", action="store_true", help="fit the backdrop to each picture instead"
    )
    parser.add_argument("--length", type=float, help="tell sensing the robot's length in mm")
    arguments = parser.parse_args()
    if arguments.folder is None:
        print("no folder of photographs was given: python benchmarks/photographs.py FOLDER")
        return
    cv2.setNumThreads(1)
    rig = _rig(arguments.folder / "calibration.json")
    node_errors, tip_errors, ratios, stages = [], [], [], []
    for pictures, truth in _pairs(arguments.folder):
        known = json.loads(truth.with_suffix(".json").read_text())
        names = [camera.camera for camera in rig]
        background = {
            name: (arguments.folder / "background" / f"{known['variant']}_0_{name}.jpg").read_bytes()
            for name in names
            if not arguments.no_background
        }
        scene = Scene.of(rig, backgrounds=background, length_mm=arguments.length)
        label = f"{pictures.parent.name}/{pictures.name} {known['shape']:<18}{known['variant']:<15}"
        try:
            shape = Refined(scene).estimate(
                {name: scene.picture(name, Path(f"{pictures}_{name}.jpg").read_bytes()) for name in names},
                0.0,
                None,
                time.perf_counter,
            )
        except SensingError as error:
            print(f"{label} refused: {error}")
            continue
        with np.load(truth) as exact:
            nodes_mm, _ = shape.nodes(exact["nodes_s"].astype(float))
            errors = np.linalg.norm(nodes_mm - exact["nodes"], axis=1)
        node_errors.append(errors)
        tip_errors.append(errors[-1])
        ratios.append(abs(shape.length_mm - 80.0) / 8.0)
        stages.append(shape.stage_s)
        print(
            f"{label} mean {errors.mean():.3f}  max {errors.max():.3f}  tip {errors[-1]:.3f} mm  "
            f"length {shape.length_mm:.3f}  gap {shape.evidence.ray_gap_mm:.3f}  flags {', '.join(shape.flags) or 'none'}"
        )
    print()
    _summary("node error, mm", np.concatenate(node_errors))
    _summary("tip error, mm", np.array(tip_errors))
    _summary("length error, mm per 10 mm", np.array(ratios))
    for stage in stages[0]:
        print(f"{stage:<12} median {1e3 * np.median([times[stage] for times in stages]):6.1f} ms")


def _pairs(folder: Path) -> list[tuple[Path, Path]]:
    return [
        (folder / pictures / exact.stem, exact)
        for pictures, truth in (("pairs", "truth"), ("sequence", "sequence/truth"))
        for exact in sorted((folder / truth).glob("*.npz"))
    ]


def _rig(path: Path) -> tuple:
    known = json.loads(path.read_text())
    cameras = known["cameras"]
    return rig_from_matrices(
        tuple(known["image_size"]),
        {name: camera["K"] for name, camera in cameras.items()},
        {name: camera["dist"] for name, camera in cameras.items()},
        {name: camera["camera_from_robot"] for name, camera in cameras.items()},
    )


def _summary(what: str, values: np.ndarray) -> None:
    print(f"{what:<28} mean {values.mean():.4f}  p95 {np.percentile(values, 95):.4f}  max {values.max():.4f}")


if __name__ == "__main__":
    main()
