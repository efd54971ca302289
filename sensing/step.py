"""One frame set's step of sensing: its inputs and the track before in, the estimate and the track after out. Pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from messaging.shape import Flag, NodalPoints, ShapeEstimate
from sensing.errors import SensingError
from sensing.pipeline import Scene, Track, estimate
from sensing.reporting import estimate_message, refusal_message


@dataclass(frozen=True, kw_only=True, eq=False)
class SetInputs:
    """What one step sees: coded pictures by camera, where the stage was and whether that is known, and what is asked."""

    jpegs: Mapping[str, bytes]
    sequence: int
    capture_time_ns: int
    insertion_mm: float
    base_known: bool
    points: NodalPoints


@dataclass(frozen=True, kw_only=True, eq=False)
class Clocks:
    """The only times in a step: seconds for how long its stages took, and the frames' age in ns once it is done."""

    stage_s: Callable[[], float]
    age_ns: Callable[[], int]


def step(
    scene: Scene, inputs: SetInputs, before: Track | None, clocks: Clocks
) -> tuple[ShapeEstimate, Track | None]:
    """The estimate or its refusal, and the track for the next step; clocks show in `stage_s` and the age alone."""
    try:
        pictures = {name: scene.picture(name, data) for name, data in inputs.jpegs.items()}
        shape = estimate(pictures, scene, inputs.insertion_mm, before, clocks.stage_s)
        extra = () if inputs.base_known else (Flag.BASE_UNKNOWN,)
        message = estimate_message(
            shape, inputs.points, inputs.sequence, inputs.capture_time_ns, clocks.age_ns(), extra
        )
    except SensingError as error:
        refusal = refusal_message(
            error, inputs.sequence, inputs.capture_time_ns, clocks.age_ns(), inputs.insertion_mm
        )
        return refusal, None
    return message, shape.track
