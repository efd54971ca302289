"""Whether cameras have moved, by how much and since when, from their scenery and from what sensing says. Pure."""

from collections.abc import Sequence

import msgspec
import numpy as np

from messaging.checked import FloatArray
from messaging.shape import Flag, ShapeEstimate
from nodal.calibration.check.scenery import Motion
from nodal.calibration.check.tracks import Track

MOVED_PX = 0.3
"""Light, shadows and coding move the scenery by less than 0.1 px in the mean; docs/calibration.md has the figures."""
TURNED_RAD = 1.5e-3
"""Shadows on the holder turn it by up to 0.4 mrad."""
SIGMAS = 4.0
TELLING_PX = 0.2
"""Where the scenery is known less well, it says nothing."""
LEAST_ALIKE = 0.7
"""Scenery that is less like the earlier one is another."""
OFTEN = 0.5
NS_PER_S = 1e9
ALL_STEPS = "`nodal calibrate cameras`, `nodal calibrate base`, `nodal calibrate background`"


class CameraFinding(msgspec.Struct, frozen=True, kw_only=True):
    """What one camera's scenery says. `moved` is None where it cannot tell; `reason` says why, or what is seen instead.

    The scenery's motion is to the right and down in the picture, and clockwise; `angle_deg` is by how much the camera would have turned
    for that, `robot_mm` what it is at the robot. `since_s` counts from the first look; None is before it.
    """

    camera: str
    moved: bool | None
    reason: str = ""
    shift_px: tuple[float, float] = (0.0, 0.0)
    turn_mrad: float = 0.0
    sigma_px: float = 0.0
    robot_mm: float = 0.0
    angle_deg: float = 0.0
    since_s: float | None = None
    shifts_px: tuple[tuple[float, float, float], ...] = ()
    """Every look: s from the first one, to the right, down."""


class SensingFinding(msgspec.Struct, frozen=True, kw_only=True):
    """What sensing said of the same frame sets: how many had a shape, the share of them that said the calibration is off, the
    median of how far a camera's picture seemed to lie elsewhere, and each camera's median residual.
    """

    shapes: int
    share_off: float
    ray_bias_mm: float
    residual_px: dict[str, float]

    @property
    def off(self) -> bool:
        """Whether it says so more often than not."""
        return self.share_off > OFTEN


class Finding(msgspec.Struct, frozen=True, kw_only=True):
    """All of it, and what to do."""

    cameras: tuple[CameraFinding, ...]
    sensing: SensingFinding
    fine: bool
    verdict: str
    advice: str = ""


def judged(
    tracks: Sequence[Track], estimates: Sequence[ShapeEstimate], robot_mm: FloatArray, begin_ns: int
) -> Finding:
    """The verdict; `robot_mm` (3,) is the place at the robot for which motions are told, `begin_ns` when looks begin."""
    cameras = tuple(_camera(track, robot_mm, begin_ns) for track in tracks)
    sensing = _sensing(estimates)
    verdict, advice = _verdict(cameras, sensing)
    return Finding(cameras=cameras, sensing=sensing, fine=not advice, verdict=verdict, advice=advice)


def _camera(track: Track, robot_mm: FloatArray, begin_ns: int) -> CameraFinding:
    camera, motions = track.camera, track.motions
    if not track.sightings:
        return CameraFinding(camera=camera.name, moved=None, reason="none of its pictures can be used")
    if not motions:
        return CameraFinding(
            camera=camera.name,
            moved=None,
            reason="too little stands still in its picture; something fixed with clear edges, such as a printed mark beside the robot, would help",
        )
    shifts = np.array([motion.shift_px for _, motion in motions])
    since = _step(shifts)
    later = [motion for _, motion in motions[since:]]
    shift, turn = np.median(shifts[since:], axis=0), float(np.median([motion.turn_rad for motion in later]))
    sigma = float(np.median([motion.sigma_px for motion in later]))
    times_s = [(time_ns - begin_ns) / NS_PER_S for time_ns, _ in motions]
    size = float(np.linalg.norm(shift))
    size_mm = size / float(camera.px_per_mm(robot_mm[None])[0])
    away_mm = float(np.linalg.norm(robot_mm - camera.centre_mm))
    told = CameraFinding(
        camera=camera.name,
        moved=size > max(MOVED_PX, SIGMAS * sigma) or abs(turn) > TURNED_RAD,
        shift_px=(float(shift[0]), float(shift[1])),
        turn_mrad=1e3 * turn,
        sigma_px=sigma,
        robot_mm=size_mm,
        angle_deg=float(np.degrees(size_mm / away_mm)),
        since_s=times_s[since] if since else None,
        shifts_px=tuple((at, float(x), float(y)) for at, (x, y) in zip(times_s, shifts, strict=True)),
    )
    return _doubted(told, later)


def _doubted(told: CameraFinding, motions: Sequence[Motion]) -> CameraFinding:
    alike = float(np.median([motion.alike for motion in motions]))
    if alike < LEAST_ALIKE:
        reason = (
            f"its picture shows other scenery than the background picture (correlation {alike:.2f}): the camera looks elsewhere, "
            "or what stands before it has changed"
        )
        return msgspec.structs.replace(told, moved=None, reason=reason)
    if told.sigma_px > TELLING_PX and not told.moved:
        reason = f"its scenery tells a motion to {told.sigma_px:.2f} px only"
        return msgspec.structs.replace(told, moved=None, reason=reason)
    return told


def _step(shifts: FloatArray) -> int:
    """The look (of n) at which the scenery has jumped; 0 when it lay alike all along."""
    best, since = float(((shifts - shifts.mean(axis=0)) ** 2).sum()), 0
    for number in range(1, len(shifts)):
        parts = shifts[:number], shifts[number:]
        means = [np.median(part, axis=0) for part in parts]
        rest = float(sum(((part - mean) ** 2).sum() for part, mean in zip(parts, means, strict=True)))
        if rest < best and np.linalg.norm(means[1] - means[0]) > MOVED_PX:
            best, since = rest, number
    return since


def _sensing(estimates: Sequence[ShapeEstimate]) -> SensingFinding:
    shapes = [estimate for estimate in estimates if not estimate.refusal]
    residuals: dict[str, list[float]] = {}
    for estimate in shapes:
        for name, residual in zip(estimate.camera_names, estimate.camera_residual_px, strict=True):
            residuals.setdefault(name, []).append(float(residual))
    off = sum(Flag.CALIBRATION_OFF in estimate.flags for estimate in shapes)
    return SensingFinding(
        shapes=len(shapes),
        share_off=off / max(len(shapes), 1),
        ray_bias_mm=float(np.median([estimate.ray_bias_mm for estimate in shapes])) if shapes else 0.0,
        residual_px={name: float(np.median(values)) for name, values in residuals.items()},
    )


def _verdict(cameras: Sequence[CameraFinding], sensing: SensingFinding) -> tuple[str, str]:
    moved = [one.camera for one in cameras if one.moved]
    blind = [one.camera for one in cameras if one.moved is None]
    if moved and len(moved) == len(cameras) and sensing.shapes and not sensing.off:
        return (
            "all cameras have moved, and they still agree with one another: they moved together, or the robot's stand did",
            "find the robot frame again (`nodal calibrate base`), then the background (`nodal calibrate background`)",
        )
    if moved:
        return (
            f"{_these(moved)} moved",
            f"calibrate again: {ALL_STEPS}; unless it was the backdrop or the holder that moved: then the background alone",
        )
    if sensing.off:
        return (
            "the scenery lies where it lay, but the cameras contradict one another",
            f"the calibration was off before, the cameras are out of step, or a lens has changed; look, then calibrate again: {ALL_STEPS}",
        )
    if any(one.reason.startswith("its picture shows other scenery") for one in cameras):
        return (
            f"{', '.join(blind)}: other scenery than in the background picture",
            f"if nothing before the cameras was changed, calibrate again: {ALL_STEPS}; else the background alone",
        )
    if blind:
        return (
            f"nothing speaks against the calibration, but {', '.join(blind)} cannot be told by the scenery",
            "",
        )
    return "fine: no camera has moved", ""


def _these(names: Sequence[str]) -> str:
    return f"camera {names[0]} has" if len(names) == 1 else f"cameras {' and '.join(names)} have"
