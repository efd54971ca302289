"""Opens a recording in Rerun, laid out for a bench: robot and cameras in space, each camera's picture with the centreline.

pip install rerun-sdk
python in_rerun.py LOG.mcap
"""

import sys

import rerun
from rerun import blueprint
from rerun.chunk import McapReader

MILLIMETRE = 0.001
RADII = {"centreline": 0.6, "nodal_points": 1.6, "desired": 1.2, "path": 0.3}


def layout(cameras: list[str]) -> blueprint.Blueprint:
    """Space on the left, one picture a camera on the right, log lines below."""
    shape = [f"/shape/{name}" for name in ("centreline", "nodal_points")]
    targets = ["/controller/desired", "/target/path"]
    sizes = {
        entity: rerun.Points3D.from_fields(radii=MILLIMETRE * RADII[entity.rpartition("/")[2]])
        for entity in shape + targets
    }
    frustums = {
        f"/camera/{camera}/calibration": rerun.Pinhole.from_fields(image_plane_distance=60 * MILLIMETRE)
        for camera in cameras
    }
    in_space = blueprint.Spatial3DView(
        name="robot",
        origin="/",
        overrides=sizes | frustums,
        eye_controls=blueprint.EyeControls3D(position=(0.13, 0.16, 0.13), look_target=(0, -0.07, 0.03)),
    )
    pictures = [
        blueprint.Spatial2DView(
            name=camera, origin=f"/camera/{camera}", contents=["$origin/**", *shape], overrides=sizes
        )
        for camera in cameras
    ]
    lines = blueprint.TextLogView(name="log", origin="/log")
    return blueprint.Blueprint(
        blueprint.Vertical(
            blueprint.Horizontal(in_space, blueprint.Vertical(*pictures), column_shares=[3, 2]),
            lines,
            row_shares=[4, 1],
        ),
        collapse_panels=True,
    )


def cameras_in(recording: str) -> list[str]:
    """The names of its cameras."""
    topics = [channel.topic.split("/") for channel in McapReader(recording).info().channels]
    return [words[1] for words in topics if words[0] == "camera" and len(words) == 2]


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} LOG.mcap")
    rerun.init("nodal", spawn=True, default_blueprint=layout(cameras_in(sys.argv[1])))
    rerun.log_file_from_path(sys.argv[1])
