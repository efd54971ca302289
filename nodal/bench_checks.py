"""What must agree between the rooms' settings, so that a bench that cannot work says so before anything moves. Pure."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.cameras.v4l2.settings import V4l2CameraSettings
from messaging.frames import CameraCalibration
from nodal.errors import BenchFileError

if TYPE_CHECKING:
    from nodal.bench_settings import BenchSettings


def check(path: Path, settings: "BenchSettings", rig: Mapping[str, CameraCalibration] | None = None) -> None:
    """Raises BenchFileError with everything in the bench file that does not agree, and everything that does not agree with the
    calibration, `rig` by camera, where there is one.
    """
    faults = [
        *([] if rig is None else _cameras(settings, rig)),
        *_devices(settings),
        *_backgrounds(settings),
        *([] if rig is None else _work_areas(settings, rig)),
        *_nodal_points(settings),
        *_tendons(settings),
        *_identified(settings),
        *_simulation(settings),
    ]
    if faults:
        raise BenchFileError(f"{path}: " + "; ".join(faults))


def _cameras(settings: "BenchSettings", rig: Mapping[str, CameraCalibration]) -> Iterator[str]:
    for name in settings.cameras:
        if name not in rig:
            yield f"cameras.{name} is not in the calibration {settings.calibration}, which has {', '.join(rig)}"
    for name, camera in _webcams(settings).items():
        known = rig.get(name)
        if known is not None and (camera.width_px, camera.height_px) != (known.width_px, known.height_px):
            yield (
                f"cameras.{name} is asked for {camera.width_px}x{camera.height_px} px, but was calibrated at "
                f"{known.width_px}x{known.height_px} px"
            )


def _webcams(settings: "BenchSettings") -> dict[str, V4l2CameraSettings]:
    return {
        name: camera for name, camera in settings.cameras.items() if isinstance(camera, V4l2CameraSettings)
    }


def _devices(settings: "BenchSettings") -> Iterator[str]:
    users: dict[str, list[str]] = {}
    for name, camera in _webcams(settings).items():
        users.setdefault(camera.device, []).append(f"cameras.{name}")
    for device, names in users.items():
        if len(names) > 1:
            yield f"{' and '.join(names)} have the same device {device}"


def _backgrounds(settings: "BenchSettings") -> Iterator[str]:
    for name in settings.sensing.background:
        if name not in settings.cameras:
            yield f"sensing.background.{name} is not one of the cameras {', '.join(settings.cameras)}"


def _work_areas(settings: "BenchSettings", rig: Mapping[str, CameraCalibration]) -> Iterator[str]:
    if not settings.sensing.work_area:
        return
    import numpy as np  # noqa: PLC0415  this and OpenCV are slow to import, and most benches have no work area

    from sensing.pictures.work_area import work_area_faults  # noqa: PLC0415

    areas = {name: np.array(corners) for name, corners in settings.sensing.work_area.items()}
    calibrations = tuple(rig[name] for name in settings.cameras if name in rig)
    yield from (f"sensing.{fault}" for fault in work_area_faults(areas, calibrations))


def _nodal_points(settings: "BenchSettings") -> Iterator[str]:
    points, length_mm = settings.sensing.nodal_points, settings.robot.length_mm
    for index, point in enumerate(points):
        if point.arc_mm > length_mm:
            yield (
                f"sensing.nodal_points[{index}] {point.name} at {point.arc_mm:g} mm is beyond the robot, "
                f"whose sections add up to {length_mm:g} mm"
            )
    arcs, names = [point.arc_mm for point in points], [point.name for point in points]
    if arcs != sorted(set(arcs)):
        yield f"sensing.nodal_points: distances {arcs} mm must increase"
    if len(set(names)) != len(names):
        yield f"sensing.nodal_points: every name must be used once, not {names}"


def _tendons(settings: "BenchSettings") -> Iterator[str]:
    sections, controlled = len(settings.robot.section_length_mm), len(settings.controller.sections)
    if controlled != sections:
        yield f"controller.sections describes {controlled} sections; robot.section_length_mm has {sections}"
    needed = sum(len(section.angle_deg) for section in settings.controller.sections)
    if len(settings.servos.tendons) != needed:
        yield (
            f"servos.tendons has {len(settings.servos.tendons)} servos; controller.sections needs {needed}, one for each "
            "pair or single tendon"
        )
    reach_mm, current_ma = settings.controller.limits.displacement_mm, settings.controller.limits.current_ma
    for axis in settings.servos.tendons:
        if axis.min_mm > -reach_mm or axis.max_mm < reach_mm:
            yield (
                f"controller.limits.displacement_mm {reach_mm:g} reaches beyond servo {axis.name}, "
                f"which travels {axis.min_mm:g} to {axis.max_mm:g} mm"
            )
    for axis in settings.servos.axes:
        if axis.max_current_ma <= current_ma:
            yield (
                f"servo {axis.name} bounds itself at max_current_ma {axis.max_current_ma:g}, so controller.limits.current_ma "
                f"{current_ma:g} would never be exceeded; it must be lower"
            )
    yield from _stage(settings)


def _identified(settings: "BenchSettings") -> Iterator[str]:
    identified = settings.controller.identified
    if identified is None:
        return
    mm_per_rad = tuple(axis.mm_per_rad for axis in settings.servos.axes)
    if changed := identified.drawing.differences(settings.controller.drawing(settings.robot, mm_per_rad)):
        yield (
            f"controller.identified is a correction of another drawing: {', '.join(changed)}; "
            "take the table out, then run `nodal calibrate robot`"
        )


def _stage(settings: "BenchSettings") -> Iterator[str]:
    travel, stage = settings.controller.limits.insertion_mm, settings.servos.stage
    if stage is not None and stage.zero_ticks is None:
        yield (
            "servos.stage.zero_ticks is missing: without it the stage's travel would begin wherever it stands when its servo is "
            "found, again after every lost cable; bring the stage to its zero and take the position that "
            f"`nodal servos list --port {settings.servos.port}` shows for servo {stage.id}"
        )
    if settings.robot.stage != (stage is not None):
        yield f"robot.stage is {str(settings.robot.stage).lower()}; servos.stage is {'missing' if stage is None else 'given'}"
    elif stage is not None and (travel[0] < stage.min_mm or travel[1] > stage.max_mm):
        yield (
            f"controller.limits.insertion_mm {list(travel)} reaches beyond "
            f"servos.stage, which travels {stage.min_mm:g} to {stage.max_mm:g} mm"
        )


def _simulation(settings: "BenchSettings") -> Iterator[str]:
    if settings.simulation is None:
        return
    lengths = tuple(section.length_mm for section in settings.simulation.robot.sections)
    if lengths != settings.robot.section_length_mm:
        yield (
            f"simulation.robot.sections are {list(lengths)} mm long; "
            f"robot.section_length_mm says {list(settings.robot.section_length_mm)}"
        )
