"""The table of topics: who says what, how often, how old it may get, and whether it is logged.

Publications are reliable while the receiver keeps up, and cannot block a loop: what cannot be sent at once is dropped,
and counted by the gap that it leaves in the sequence numbers. Publishers, subscribers, liveness, the recorder, the documentation and the tests read this table; nothing else names a
key. Keys stand below `nodal/<bench name>/`; a `*` in a key is a camera's name.
"""

import dataclasses

from messaging.control import ActionRequest, ControllerState, Reply, Target, TendonCommand, TendonState
from messaging.frames import Frame
from messaging.history import Asked, Memory
from messaging.message import Message
from messaging.recorder import RecorderRequest
from messaging.scene import SceneRequest
from messaging.shape import NodalPoints, ShapeEstimate, Truth
from messaging.views import (
    CameraPoseView,
    CameraView,
    CentrelineView,
    DesiredPointsView,
    LogLine,
    NodalPointsView,
    TargetPathView,
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Topic:
    """One line of the table. `rate_hz` is what is expected of it (None: now and then), `maximum_age_s` when it is stale."""

    key: str
    type: type[Message]
    said_by: str
    meaning: str
    rate_hz: float | None = None
    maximum_age_s: float | None = None
    logged: bool = True

    def named(self, name: str) -> "Topic":
        """This topic for one camera."""
        return dataclasses.replace(self, key=self.key.replace("*", name))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Service:
    """A key that answers queries: a request of one type, a `Reply` in return."""

    key: str
    request: type[Message]
    answered_by: str
    meaning: str
    reply: type[Reply] = Reply


@dataclasses.dataclass(frozen=True, kw_only=True)
class Signal:
    """A plain key: that something is published on it counts, whatever it is, so that a button box can do it too."""

    key: str
    said_by: str
    meaning: str


CAMERA = Topic(
    key="camera/*",
    type=Frame,
    said_by="sensing",
    meaning="one camera's frame as it came; the sequence number of its set ties the cameras together",
    rate_hz=30,
    maximum_age_s=0.2,
)
CAMERA_CALIBRATION = Topic(
    key="camera/*/calibration",
    type=CameraView,
    said_by="sensing",
    meaning="intrinsics that sensing works with",
    rate_hz=1,
)
CAMERA_POSE = Topic(
    key="camera/*/pose",
    type=CameraPoseView,
    said_by="sensing",
    meaning="the camera in the robot frame",
    rate_hz=1,
)
SHAPE = Topic(
    key="shape",
    type=ShapeEstimate,
    said_by="sensing",
    meaning="centreline, nodal points with covariance, quality and flags, or the reason of a refusal",
    rate_hz=30,
    maximum_age_s=0.1,
)
CENTRELINE = Topic(
    key="shape/centreline",
    type=CentrelineView,
    said_by="sensing",
    meaning="the centreline for viewers",
    rate_hz=30,
)
NODAL_POINTS = Topic(
    key="shape/nodal_points",
    type=NodalPointsView,
    said_by="sensing",
    meaning="the nodal points for viewers",
    rate_hz=30,
)
TARGET = Topic(
    key="target",
    type=Target,
    said_by="controller",
    meaning="the target that was accepted: which nodal points go where",
)
TENDON_COMMAND = Topic(
    key="tendon/command",
    type=TendonCommand,
    said_by="controller",
    meaning="what was asked of each tendon pair and the stage",
    rate_hz=200,
    maximum_age_s=0.05,
)
TENDON_STATE = Topic(
    key="tendon/state",
    type=TendonState,
    said_by="controller",
    meaning="what the servos report",
    rate_hz=200,
    maximum_age_s=0.05,
)
CONTROLLER_STATE = Topic(
    key="controller/state",
    type=ControllerState,
    said_by="controller",
    meaning="state, reason, tracking error, loop timing, what this cycle saw",
    rate_hz=200,
    maximum_age_s=0.05,
)
TARGET_PATH = Topic(
    key="target/path",
    type=TargetPathView,
    said_by="controller",
    meaning="the places of an accepted target, for viewers",
)
DESIRED_POINTS = Topic(
    key="controller/desired",
    type=DesiredPointsView,
    said_by="controller",
    meaning="where the target's nodal points should have been when the newest shape was captured, for viewers",
    rate_hz=30,
)
ASKED = Topic(
    key="asked",
    type=Asked,
    said_by="all",
    meaning="what an operator asked, and what was answered; and stop signals that were heard",
)
SENSING_MEMORY = Topic(
    key="sensing/memory",
    type=Memory,
    said_by="sensing",
    meaning="what sensing carries from one frame set to the next",
    rate_hz=1,
)
CONTROLLER_MEMORY = Topic(
    key="controller/memory",
    type=Memory,
    said_by="controller",
    meaning="what the controller carries from one cycle to the next",
    rate_hz=1,
)
LOG = Topic(key="log", type=LogLine, said_by="all", meaning="log lines")
TRUTH = Topic(
    key="truth",
    type=Truth,
    said_by="simulated bench",
    meaning="the true centreline, for reports; nothing in the loop subscribes to it",
    rate_hz=30,
)
SIMULATED_CAMERA = Topic(
    key="simulated/camera/*",
    type=Frame,
    said_by="simulated bench",
    meaning="what a simulated camera hands to its driver; capture times on the host's monotonic clock",
    rate_hz=30,
    maximum_age_s=0.2,
    logged=False,
)

TOPICS = (
    CAMERA,
    CAMERA_CALIBRATION,
    CAMERA_POSE,
    SHAPE,
    CENTRELINE,
    NODAL_POINTS,
    TARGET,
    TENDON_COMMAND,
    TENDON_STATE,
    CONTROLLER_STATE,
    TARGET_PATH,
    DESIRED_POINTS,
    ASKED,
    SENSING_MEMORY,
    CONTROLLER_MEMORY,
    LOG,
    TRUTH,
    SIMULATED_CAMERA,
)

CONTROLLER_DO = Service(
    key="controller/do",
    request=ActionRequest,
    answered_by="controller",
    meaning="home, arm, hold, pause, resume, abort, jog, relax, stop, status: what happened, and why not",
)
CONTROLLER_TARGET = Service(
    key="controller/target",
    request=Target,
    answered_by="controller",
    meaning="a target, checked and answered before anything moves; what is accepted is said on `target`",
)
SENSING_NODES = Service(
    key="sensing/nodes",
    request=NodalPoints,
    answered_by="sensing",
    meaning="new nodal points; refused when they are not on the robot",
)
RECORDER_DO = Service(
    key="recorder/do",
    request=RecorderRequest,
    answered_by="recorder",
    meaning="start, stop, save, status",
)
SIMULATION_SCENE = Service(
    key="simulation/scene",
    request=SceneRequest,
    answered_by="simulation",
    meaning="what stands before the simulated cameras: robot, empty, board, board_at_base",
)
SERVICES = (CONTROLLER_DO, CONTROLLER_TARGET, SENSING_NODES, RECORDER_DO, SIMULATION_SCENE)

STOP = Signal(
    key="stop",
    said_by="operator",
    meaning="the controller stops in the cycle in which it hears it, from any state",
)
HEARTBEAT = Signal(
    key="operator/heartbeat",
    said_by="operator",
    meaning="somebody is there; needed where `controller.operator.heartbeat_s` asks for it",
)
SIGNALS = (STOP, HEARTBEAT)
