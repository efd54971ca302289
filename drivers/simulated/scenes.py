"""What stands before the simulated cameras, and whoever asks for something else there."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.cameras.process import CameraProcess
from drivers.simulated.cameras.schedule import NS_PER_S, Pose
from drivers.simulated.cameras.subjects import BoardBeforeHolder, EmptyHolder, RobotInHolder, Subject
from drivers.simulated.hands import Hands
from messaging.board import BoardPlace
from messaging.control import Reply
from messaging.errors import CodecError, InvalidMessageError
from messaging.scene import Scene, SceneRequest
from messaging.session import Query, Session
from messaging.topics import SIMULATION_SCENE

Array = NDArray[np.float64]

_AT_ZERO_MM = 0.1


class Scenes:
    """One scene at a time, the robot's at first. A request is answered once every camera has sent pictures of its scene."""

    def __init__(
        self,
        session: Session,
        cameras: Sequence[CameraProcess],
        hands: Hands,
        at_base: BoardPlace | None,
    ) -> None:
        """`hands` begin anew each time the board is asked for; `at_base` is where it stands in its fixture, if there is one."""
        self._answers = session.answers(SIMULATION_SCENE)
        self._cameras = cameras
        self._hands = hands
        self._at_base = at_base
        self._scene, self._begun_ns = Scene.ROBOT, 0
        self._asked: Query | None = None
        self.number = 0
        """How often a scene was set."""

    @property
    def robot_is_seen(self) -> bool:
        """Whether the robot stands in its holder."""
        return self._scene is Scene.ROBOT

    def attend(self, now: Pose) -> None:
        """Hear what is asked, and answer what has come about; raises SimulatedCameraError."""
        while (query := self._answers.take()) is not None:
            self._hear(query, now)
        if self._asked is not None and all(camera.scene == self.number for camera in self._cameras):
            self._answer(self._asked)
            self._asked = None

    def subject(self, opened: Pose, closed: Pose) -> Subject:
        """What a camera sees whose shutter opens and closes with the robot, in its holder or not, posed like this."""
        if self._scene is Scene.ROBOT:
            return RobotInHolder(opened_mm=opened.centreline_mm, closed_mm=closed.centreline_mm)
        base_mm = (opened.centreline_mm[0] + closed.centreline_mm[0]) / 2
        if self._scene is Scene.EMPTY:
            return EmptyHolder(base_mm=base_mm)
        return BoardBeforeHolder(
            base_mm=base_mm,
            opened=self._robot_from_board(opened.time_ns),
            closed=self._robot_from_board(closed.time_ns),
        )

    def _robot_from_board(self, time_ns: int) -> Array:
        if self._scene is Scene.BOARD_AT_BASE and self._at_base is not None:
            return self._at_base.robot_from_board
        return self._hands.at((time_ns - self._begun_ns) / NS_PER_S)

    def _hear(self, query: Query, now: Pose) -> None:
        try:
            request = query.request()
        except (CodecError, InvalidMessageError) as error:
            self._answer(query, str(error))
            return
        if not isinstance(request, SceneRequest):
            raise TypeError(f"{SIMULATION_SCENE.key} was asked {type(request).__name__}")
        if reason := self._reason_against(request.scene, float(now.centreline_mm[0, 2])):
            self._answer(query, reason)
            return
        if self._asked is not None:
            self._answer(self._asked, f"scene {request.scene} was asked for before this one stood")
        self._scene, self._begun_ns, self._asked = request.scene, now.time_ns, query
        self.number += 1

    def _reason_against(self, scene: Scene, insertion_mm: float) -> str:
        if scene is not Scene.BOARD_AT_BASE:
            return ""
        if self._at_base is None:
            return "the bench file has no [board.at_base], which says where the board stands in its fixture"
        if abs(insertion_mm) > _AT_ZERO_MM:
            return f"the stage stands at {insertion_mm:.2f} mm; the board at the base is known with the stage at zero"
        return ""

    def _answer(self, query: Query, reason: str = "") -> None:
        query.reply(Reply(accepted=not reason, state=self._scene, reason=reason))
