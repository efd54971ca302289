"""Where the robot is now: what sensing and the controller say on the bus, or what the bench file says of a robot at rest."""

import dataclasses
import time
from collections.abc import Mapping
from typing import Self

import numpy as np
from numpy.typing import NDArray

from controller.planning.plan import present_shape
from controller.planning.space import Space
from messaging.control import ControllerState, State
from messaging.errors import CodecError, InvalidMessageError
from messaging.session import Session
from messaging.shape import ShapeEstimate
from messaging.topics import CONTROLLER_STATE, SHAPE
from nodal.bench_settings import BenchSettings
from nodal.errors import CommandError

Array = NDArray[np.float64]

_FITTED_POINTS = 16
_ASK_AGAIN_S = 0.02


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Present:
    """The nodal points by name, along the robot and in space, and the configuration (C,) that the model gives the shape."""

    words: str
    node_arc_mm: Mapping[str, float]
    node_mm: Mapping[str, Array]
    configuration: Array

    @classmethod
    def straight(cls, bench: BenchSettings, space: Space) -> Self:
        """Homed, the stage as near to zero as it goes, and the nodal points of the bench file."""
        configuration = space.straight(0.0)
        arcs = {point.name: point.arc_mm for point in bench.sensing.nodal_points}
        nodes, _ = space.nodes_and_jacobian(configuration, np.array(list(arcs.values())))
        return cls(
            words="the straight robot",
            node_arc_mm=arcs,
            node_mm=dict(zip(arcs, nodes, strict=True)),
            configuration=configuration,
        )

    @classmethod
    def of(cls, shape: ShapeEstimate, state: ControllerState | None, space: Space) -> Self:
        """As it is seen; nodal points that the controller leads are where it leads them."""
        places = dict(zip(shape.node_names, shape.node_mm, strict=True))
        if state is not None and state.state is State.TRACKING:
            led = dict(zip(state.node_names, state.desired_mm, strict=True))
            places |= {name: led[name] for name in places if name in led}
        some = np.unique(np.linspace(0, len(shape.arc_mm) - 1, _FITTED_POINTS).round().astype(int))
        return cls(
            words="the present shape",
            node_arc_mm=dict(zip(shape.node_names, shape.node_arc_mm.tolist(), strict=True)),
            node_mm=places,
            configuration=present_shape(
                space, shape.centreline_mm[some], shape.arc_mm[some], shape.insertion_mm
            ),
        )

    @classmethod
    def on(cls, session: Session, space: Space, timeout_s: float) -> Self:
        """As it is said on the bus; raises CommandError when no trusted shape comes in time."""
        shapes, states = session.newest(SHAPE), session.newest(CONTROLLER_STATE)
        deadline = time.monotonic() + timeout_s
        state: ControllerState | None = None
        why = "none came"
        while time.monotonic() < deadline:
            try:
                said, seen = states.take(), shapes.take()
            except (CodecError, InvalidMessageError) as error:
                why = str(error)
                continue
            if said is not None and isinstance(said[0], ControllerState):
                state = said[0]
            if seen is not None and isinstance(seen[0], ShapeEstimate):
                if seen[0].trusted and len(seen[0].arc_mm) > 1:
                    return cls.of(seen[0], state, space)
                why = seen[0].refusal or f"the newest is flagged {', '.join(seen[0].flags)}"
            time.sleep(_ASK_AGAIN_S)
        raise CommandError(
            f"no trusted shape within {timeout_s:g} s: {why}; is sensing running on this bench?"
        )
