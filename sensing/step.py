"""One frame set's step of sensing: its inputs and the track before in, the estimate and the track after out. Pure."""

from collections.abc import Callable
from dataclasses import dataclass

from messaging.shape import ShapeEstimate
from sensing.errors import SensingError
from sensing.method import Method
from sensing.refined.track import Track
from sensing.reporting import estimate_message, refusal_message
from sensing.set_inputs import SetInputs


@dataclass(frozen=True, kw_only=True, eq=False)
class Clocks:
    """The only times in a step: seconds for how long its stages took, and the frames' age in ns once it is done."""

    stage_s: Callable[[], float]
    age_ns: Callable[[], int]


def step(
    method: Method, inputs: SetInputs, before: Track | None, clocks: Clocks
) -> tuple[ShapeEstimate, Track | None]:
    """The estimate or its refusal, and the track for the next step; clocks show in `stage_s` and the age alone."""
    try:
        pictures = {name: method.scene.picture(name, data) for name, data in inputs.jpegs.items()}
        shape = method.estimate(pictures, inputs.insertion_mm, before, clocks.stage_s)
        return estimate_message(shape, inputs, method, clocks.age_ns()), shape.track
    except SensingError as error:
        return refusal_message(error, inputs, method, clocks.age_ns()), None
