"""One frame set's step of sensing: its inputs and the track before in, the estimate and the track after out. Pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from messaging.shape import Flag, ShapeEstimate
from sensing.errors import PictureError, RefusedError, SensingError
from sensing.method import Method
from sensing.pictures.picture import Picture
from sensing.refined.track import Track
from sensing.reporting import estimate_message, refusal_message
from sensing.set_inputs import SetInputs
from sensing.shape import Shape

LEAST_CAMERAS = 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Clocks:
    """The only times in a step: seconds for how long its stages took, and the frames' age in ns once it is done."""

    stage_s: Callable[[], float]
    age_ns: Callable[[], int]


class Outcome(NamedTuple):
    """The estimate or its refusal, the track for the next step, and by camera why its picture was not used."""

    estimate: ShapeEstimate
    track: Track | None
    lost: Mapping[str, str]


def step(method: Method, inputs: SetInputs, before: Track | None, clocks: Clocks) -> Outcome:
    """The estimate or its refusal; clocks show in `stage_s` and the age alone.

    A camera without a picture that can be used is left out while two others have one; the estimate is flagged then.
    """
    lost: dict[str, str] = {}
    try:
        shape = seen_by_the_rest(method, inputs, before, clocks, lost)
        message = estimate_message(shape, inputs, method, clocks.age_ns())
    except SensingError as error:
        # a picture that cannot be used says nothing of where the robot is
        track = before if isinstance(error, PictureError) else None
        return Outcome(refusal_message(error, inputs, method, clocks.age_ns()), track, lost)
    return Outcome(message, shape.track, lost)


def seen_by_the_rest(
    method: Method, inputs: SetInputs, before: Track | None, clocks: Clocks, lost: dict[str, str]
) -> Shape:
    """The shape as the cameras see it that are not lost; those without a picture that can be used are put into `lost`."""
    for camera in method.scene.cameras:
        if camera.name not in inputs.jpegs:
            lost[camera.name] = f"camera {camera.name}: no frame in this set"
    pictures: dict[str, Picture] = {}
    while True:
        left = type(method)(method.scene.without(lost)) if lost else method
        names = [camera.name for camera in left.scene.cameras]
        if len(names) < LEAST_CAMERAS:
            raise RefusedError(f"{'; '.join(lost.values())}; two cameras at least must see the robot")
        try:
            for name in names:
                pictures[name] = pictures.get(name) or left.scene.picture(name, inputs.jpegs[name])
            shape = left.estimate(pictures, inputs.insertion_mm, before, clocks.stage_s)
        except PictureError as error:
            if len(names) == LEAST_CAMERAS:
                raise
            lost[error.camera] = str(error)
            continue
        if not lost:
            return shape
        flags = (*shape.evidence.flags, Flag.CAMERA_LOST)
        return replace(shape, evidence=replace(shape.evidence, flags=flags))
