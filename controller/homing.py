"""Finding the slack of every tendon, before the robot is led straight: by the cameras and by current. Pure.

A pair of tendons is pulled one way until the robot follows, and then the other way until it follows again. What the axis
travels in between without being followed is its lost motion, by play and by friction; its middle is where the search
leaves the axis. A single tendon is tightened until the robot follows, or its current rises. What never answers is slack or
snapped; what goes another way than the model says is wired or signed the wrong way.

The robot is compared with where the servo stood when the frames were taken, so delay does not count as lost motion.
"""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from controller.errors import FaultError
from controller.faults import HomingTimeoutError, TendonSlackError, WrongWayError
from controller.history import History
from controller.limits import axis_name
from controller.plant import Plant
from controller.probing import Rest, Search, Sight, Stroke
from controller.settings import HomingSettings
from controller.task import Seen
from drivers.actuators import ActuatorState

Array = NDArray[np.float64]

_REST_SHAPES = 3
"""So many shapes in which the robot stands still say where it rests."""
_CURRENT_S = 0.05
"""Time constant over which currents are averaged: they jump when a servo starts to move."""
_THERE_MM = 1e-6
_SURE = 8.0
"""How many standard deviations of a coordinate a nodal point must move to be seen to move."""
_SAME_WAY = 0.3
"""Cosine between the motion that is seen and the model's, below which the two have nothing to do with one another."""


class SlackSearch:
    """The search on one robot."""

    def __init__(self, settings: HomingSettings, plant: Plant) -> None:
        """Stages have no slack to be found."""
        self._settings = settings
        self._plant = plant
        self._tendons = plant.kinematics.tendons

    def start(self, command_mm: Array, drive: ActuatorState, now_s: float) -> Search:
        """At the first axis, with everything at rest."""
        return self._rest(0, command_mm, drive, np.full(len(command_mm), np.nan), now_s)

    def words(self, search: Search) -> str:
        """What is being done."""
        tightens = search.stroke in (Stroke.TIGHTEN, Stroke.LOOK)
        doing = "tightening" if tightens else "finding the slack of"
        return f"{doing} {self._name(search)}"

    def step(
        self,
        search: Search,
        seen: Seen | None,
        *,
        command_mm: Array,
        drive: ActuatorState,
        now_s: float,
        dt_s: float,
    ) -> tuple[Search, Array, bool]:
        """The search after this cycle, the command (A,), and whether all axes are done.

        Raises TendonSlackError, WrongWayError or HomingTimeoutError.
        """
        axis = search.axis
        share = min(dt_s / _CURRENT_S, 1.0)
        search = dataclasses.replace(
            search,
            positions=search.positions.then(now_s, drive.position_mm[axis, None]),
            current_ma=search.current_ma + share * (float(drive.current_ma[axis]) - search.current_ma),
        )
        match search.stroke:
            case Stroke.REST:
                return self._resting(search, seen, now_s), command_mm, False
            case Stroke.FORTH:
                search = self._forth(search, seen, now_s)
            case Stroke.BACK:
                search = self._back(search, seen, float(drive.position_mm[axis]), now_s)
            case Stroke.TIGHTEN:
                search, tight = self._answered(search, self._sight(search, seen))
                if tight:
                    return dataclasses.replace(search, stroke=Stroke.LOOK, since_s=now_s), command_mm, False
            case Stroke.LOOK:
                if self._looked(search, seen):
                    return self._next(search, command_mm, drive, now_s)
                return search, command_mm, False
            case Stroke.MIDDLE if abs(command_mm[axis] - search.goal_mm) < _THERE_MM:
                return self._next(search, command_mm, drive, now_s)
        most_mm = self._settings.probe_mm_s * dt_s
        wanted = command_mm.copy()
        wanted[axis] += min(max(search.goal_mm - wanted[axis], -most_mm), most_mm)
        if abs(wanted[axis] - command_mm[axis]) < _THERE_MM and search.stroke is not Stroke.MIDDLE:
            raise self._unanswered(search)
        return search, wanted, False

    def _rest(
        self, axis: int, command_mm: Array, drive: ActuatorState, lost_motion_mm: Array, now_s: float
    ) -> Search:
        return Search(
            axis=axis,
            stroke=Stroke.REST,
            since_s=now_s,
            begin_mm=float(command_mm[axis]),
            lost_motion_mm=lost_motion_mm,
            positions=History.of(now_s, drive.position_mm[axis, None]),
            current_ma=float(drive.current_ma[axis]),
        )

    def _next(
        self, search: Search, command_mm: Array, drive: ActuatorState, now_s: float
    ) -> tuple[Search, Array, bool]:
        axis = search.axis + 1
        if axis == self._tendons:
            return search, command_mm, True
        return self._rest(axis, command_mm, drive, search.lost_motion_mm, now_s), command_mm, False

    def _resting(self, search: Search, seen: Seen | None, now_s: float) -> Search:
        """Until the robot was seen standing still often enough."""
        took_s, limit_s = now_s - search.since_s, self._settings.timeout_s
        if took_s > limit_s:
            words = f"the robot does not come to rest within {limit_s:g} s before the slack of {self._name(search)} is sought"
            raise HomingTimeoutError(words, value=took_s, limit=limit_s, unit="s")
        if seen is None or seen.capture_s < search.since_s:
            return search
        arc_mm, node_mm, rest = seen.shape.node_arc_mm, seen.shape.node_mm, search.rest
        if rest is None or not rest.shows(arc_mm) or rest.apart_mm(node_mm) > rest.seen_mm / 2:
            variance_mm2 = np.trace(seen.shape.node_covariance_mm2, axis1=1, axis2=2).max(initial=0.0) / 3
            seen_mm = max(self._settings.seen_mm, _SURE * float(np.sqrt(variance_mm2)))
            return dataclasses.replace(
                search, rest=Rest(arc_mm=arc_mm, node_mm=node_mm, shapes=1, seen_mm=seen_mm)
            )
        rest = rest.then(node_mm)
        search = dataclasses.replace(search, rest=rest)
        if rest.shapes < _REST_SHAPES:
            return search
        paired = bool(self._plant.antagonistic[search.axis])
        return dataclasses.replace(
            search,
            stroke=Stroke.FORTH if paired else Stroke.TIGHTEN,
            since_s=now_s,
            rest_ma=search.current_ma,
            goal_mm=self._reach(search, 1),
        )

    def _answered(self, search: Search, sight: Sight | None) -> tuple[Search, bool]:
        """Whether the cameras or the current say that the axis pulls; raises WrongWayError when it pulls elsewhere."""
        seen_mm = self._rest_of(search).seen_mm
        if sight is not None:
            search = dataclasses.replace(search, moved_mm=max(search.moved_mm, sight.moved_mm))
            if sight.moved_mm >= seen_mm and sight.cosine <= -_SAME_WAY:
                raise self._wrong(search, sight.cosine)
            if sight.moved_mm >= seen_mm and sight.cosine >= _SAME_WAY:
                return search, True
        pulls = self._pull_ma(search) >= self._asked_ma(search)
        if pulls and search.moved_mm >= seen_mm:
            raise self._wrong(search, 0.0)
        return search, pulls

    def _looked(self, search: Search, seen: Seen | None) -> bool:
        """Whether a shape shows what the pull did; raises WrongWayError when the robot was pulled elsewhere, though less far
        than is waited for.
        """
        if seen is None or seen.capture_s < search.since_s:
            return False
        sight = self._sight(search, seen)
        if (
            sight is not None
            and sight.moved_mm >= self._rest_of(search).seen_mm / 2
            and sight.cosine < _SAME_WAY
        ):
            raise self._wrong(search, sight.cosine)
        return True

    def _pull_ma(self, search: Search) -> float:
        """By how much the current has risen. A tendon can only resist being pulled, so one that lets go of a load that the
        servo bore the other way has not risen; a pair bears either way.
        """
        if search.stroke is Stroke.TIGHTEN:
            return search.current_ma - max(search.rest_ma, 0.0)
        return abs(search.current_ma - search.rest_ma)

    def _asked_ma(self, search: Search) -> float:
        tightens = search.stroke is Stroke.TIGHTEN
        return self._settings.tension_ma if tightens else self._settings.current_rise_ma

    def _forth(self, search: Search, seen: Seen | None, now_s: float) -> Search:
        sight = self._sight(search, seen)
        search, answered = self._answered(search, sight)
        if not answered:
            return search
        return dataclasses.replace(
            search,
            stroke=Stroke.BACK,
            since_s=now_s,
            turn_ma=search.current_ma - search.rest_ma,
            turn_mm=float(search.positions.values[-1][0]),
            followed_mm=-np.inf if sight is None else sight.followed_mm,
            goal_mm=self._reach(search, -1),
        )

    def _back(self, search: Search, seen: Seen | None, position_mm: float, now_s: float) -> Search:
        search = dataclasses.replace(search, turn_mm=max(search.turn_mm, position_mm))
        if (sight := self._sight(search, seen)) is not None:
            search = dataclasses.replace(search, followed_mm=max(search.followed_mm, sight.followed_mm))
            back_mm = search.followed_mm - sight.followed_mm
            if back_mm >= self._seen_as_mm(search):
                there_mm = float(search.positions.at(sight.capture_s)[0])
                lost_mm = max(search.turn_mm - there_mm - back_mm, 0.0)
                found = search.lost_motion_mm.copy()
                found[search.axis] = lost_mm
                return self._to_middle(search, there_mm + lost_mm / 2, found, now_s)
        push_ma = search.current_ma - search.rest_ma
        if abs(push_ma) >= self._settings.current_rise_ma and push_ma * search.turn_ma < 0:
            return self._to_middle(search, (search.turn_mm + position_mm) / 2, search.lost_motion_mm, now_s)
        return search

    def _to_middle(self, search: Search, middle_mm: float, lost_motion_mm: Array, now_s: float) -> Search:
        return dataclasses.replace(
            search, stroke=Stroke.MIDDLE, since_s=now_s, goal_mm=middle_mm, lost_motion_mm=lost_motion_mm
        )

    def _sight(self, search: Search, seen: Seen | None) -> Sight | None:
        """What a new shape says of this axis; nothing when it shows other nodal points than those of the rest."""
        if seen is None or search.rest is None or not search.rest.shows(seen.shape.node_arc_mm):
            return None
        return Sight.of(search.rest, seen.shape.node_mm, self._motion(search), seen.capture_s)

    def _motion(self, search: Search) -> Array:
        """(m, 3) how the model's nodal points move per mm of the axis."""
        straight, arc_mm = np.zeros(self._plant.kinematics.axes), self._rest_of(search).arc_mm
        return self._plant.kinematics.nodes_and_jacobian(straight, arc_mm)[1][..., search.axis]

    def _rest_of(self, search: Search) -> Rest:
        if search.rest is None:
            raise TypeError("the search moves an axis before it knows where the robot rests")
        return search.rest

    def _seen_as_mm(self, search: Search) -> float:
        """How far the axis must be followed until a nodal point has moved far enough to be seen."""
        return self._rest_of(search).seen_mm / max(
            float(np.linalg.norm(self._motion(search), axis=1).max()), 1e-12
        )

    def _reach(self, search: Search, way: int) -> float:
        """The furthest command of this axis in one direction."""
        low, high = self._plant.limits.low_mm[search.axis], self._plant.limits.high_mm[search.axis]
        return float(min(max(search.begin_mm + way * self._settings.search_mm, low), high))

    def _unanswered(self, search: Search) -> FaultError:
        seen_mm = self._rest_of(search).seen_mm
        if search.moved_mm >= seen_mm:
            return self._wrong(search, 0.0)
        limit_mm = self._settings.search_mm
        return TendonSlackError(
            f"{self._name(search)} was moved by {limit_mm:g} mm, and no nodal point moved by {seen_mm:g} mm "
            f"nor did its current rise by {self._asked_ma(search):g} mA",
            value=search.moved_mm,
            limit=seen_mm,
            unit="mm",
        )

    def _wrong(self, search: Search, cosine: float) -> FaultError:
        how = "the opposite way" if cosine <= -_SAME_WAY else "sideways"
        return WrongWayError(
            f"{self._name(search)} was pulled, and the robot went {how}: wired or signed the wrong way",
            value=cosine,
            limit=_SAME_WAY,
            unit="cosine",
        )

    def _name(self, search: Search) -> str:
        return axis_name(search.axis, self._tendons)
