"""The configurations of a robot: Clarke coordinates of its sections in mm, and where its stage stands. Pure.

Unlike commands, configurations only bend the robot: tendons that are tightened or slackened beside are no part of them.
"""

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from controller.plant import Plant

Array = NDArray[np.float64]
Count = NDArray[np.intp]

_LOOK_MM = (1.0, 2.5)
_LOOK_WITHOUT_REGIONS_MM = 5.0
_MOST_BETWEEN = 8
"""Configurations that would need more between them belong to two ways of reaching the same places."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Encroachment:
    """Where the body comes nearest to a region, or lies deepest in it: `spare_mm` is what is left of the distance it keeps."""

    index: int
    """Which of the configurations that were looked at."""
    spare_mm: float
    region: str
    arc_mm: float
    point_mm: Array


class Space:
    """All configurations (C,) of one robot, C = 2 for each section and 1 for a stage."""

    def __init__(self, plant: Plant) -> None:
        """Nothing here depends on what the robot does just now."""
        self.plant = plant
        self.kinematics = kinematics = plant.kinematics
        self._sections = len(kinematics.length_mm)
        self.coordinates = 2 * self._sections + kinematics.stage
        self.command_of = kinematics.command_of_coordinates
        """(A, C)."""
        self._bend_of = kinematics.bend_of_coordinates
        own = np.abs(self.command_of[: kinematics.tendons, : 2 * self._sections]).reshape(
            kinematics.tendons, self._sections, 2
        )
        self._first_tendon = np.searchsorted(own.sum(axis=2).argmax(axis=1), np.arange(self._sections))
        self._body_arc_mm = plant.body_arc_mm
        start_mm = np.cumsum(kinematics.length_mm) - kinematics.length_mm
        self._lever_mm = float(kinematics.length_mm.sum()) - start_mm

    def straight(self, insertion_mm: float) -> Array:
        """(C,) the straight robot with its base there, or as near as the stage can go."""
        low_mm, high_mm = self.plant.limits.stage_mm
        configuration = np.zeros(self.coordinates)
        configuration[2 * self._sections :] = min(max(insertion_mm, low_mm), high_mm)
        return configuration

    def weigh(self, coordinate: float, stage: float) -> Array:
        """(C,) one number for each Clarke coordinate, another for the stage."""
        return np.append(np.full(2 * self._sections, coordinate), [stage] * self.kinematics.stage)

    def bent(self, bend_rad: Array) -> Array:
        """(..., 2 S) coordinates of sections that bend so."""
        coordinates: Array = bend_rad @ np.linalg.inv(self._bend_of).T
        return coordinates

    def commands(self, configurations: Array) -> Array:
        """(..., A) what the actuators are told."""
        commands: Array = configurations @ self.command_of.T
        return commands

    def random(self, random: np.random.Generator) -> Array:
        """(C,) any configuration."""
        limits, tendons = self.plant.limits, self.kinematics.tendons
        reach_mm = math.sqrt(2) * np.repeat(
            np.maximum.reduceat(limits.high_mm[:tendons], self._first_tendon), 2
        )
        low, high = (
            np.append(-reach_mm, limits.low_mm[tendons:]),
            np.append(reach_mm, limits.high_mm[tendons:]),
        )
        return self.within(random.uniform(low, high))

    def within(self, configurations: Array) -> Array:
        """(..., C) near these ones, with every axis in its travel."""
        limits, tendons = self.plant.limits, self.kinematics.tendons
        commands = np.clip(self.commands(configurations), limits.low_mm, limits.high_mm)
        nearest = commands @ self.kinematics.coordinates_of_command.T
        # where tendons share a section's bend, what was cut off one of them is not the others' to make up for
        share = np.abs(self.commands(nearest)[..., :tendons]) / limits.high_mm[:tendons]
        excess = np.maximum(np.maximum.reduceat(share, self._first_tendon, axis=-1), 1.0)
        nearest[..., : 2 * self._sections] /= np.repeat(excess, 2, axis=-1)
        return nearest

    def nodes_and_jacobian(self, configurations: Array, arc_mm: Array) -> tuple[Array, Array]:
        """Points (..., m, 3) at these arc lengths, and their derivatives (..., m, 3, C)."""
        nodes, jacobian = self.kinematics.nodes_and_jacobian(self.commands(configurations), arc_mm)
        return nodes, jacobian @ self.command_of

    def body_mm(self, configurations: Array) -> Array:
        """(..., m, 3) points along the whole body. The same model as Kinematics, without its derivatives: this is asked often."""
        bend = configurations[..., : 2 * self._sections] @ self._bend_of.T
        points = np.empty((*bend.shape[:-1], len(self._body_arc_mm), 3))
        turn: Array = np.broadcast_to(np.eye(3), (*bend.shape[:-1], 3, 3))
        origin = np.zeros((*bend.shape[:-1], 3))
        origin[..., 2] = configurations[..., 2 * self._sections :].sum(axis=-1)
        begin_mm = 0.0
        for section, length_mm in enumerate(self.kinematics.length_mm):
            own = bend[..., 2 * section : 2 * section + 2]
            on_it = (self._body_arc_mm > begin_mm) & (self._body_arc_mm <= begin_mm + length_mm + 1e-9)
            share = np.append((self._body_arc_mm[on_it] - begin_mm) / length_mm, 1.0)
            arc = _arc(own, share) * length_mm
            placed = origin[..., None, :] + arc @ turn.swapaxes(-1, -2)
            points[..., on_it, :] = placed[..., :-1, :]
            origin, turn = placed[..., -1, :], turn @ _turn(own)
            begin_mm += length_mm
        return points

    def spare_mm(self, configurations: Array) -> Array:
        """(...) how much more than it must the body keeps away from regions; negative where it comes too near."""
        if not len(self.plant.regions):
            return np.full(configurations.shape[:-1], np.inf)
        distance, _ = self.plant.regions.clearance(self.body_mm(configurations))
        spare: Array = distance.min(axis=(-2, -1)) - self.plant.clearance_mm
        return spare

    @property
    def look_mm(self) -> float:
        """How far anything may move between two looks at a path: half of what is kept clear, within bounds."""
        if not len(self.plant.regions):
            return _LOOK_WITHOUT_REGIONS_MM
        return min(max(self.plant.clearance_mm / 2, _LOOK_MM[0]), _LOOK_MM[1])

    def nearest_between(self, way: Array) -> Encroachment | None:
        """Where a way (w, C) comes nearest to a region, looked at so often that no point of the body moves farther than
        `look_mm`; counted by the nearest of these configurations.
        """
        parts = np.clip(np.ceil(self.sweep_mm(np.diff(way, axis=0)) / self.look_mm), 1, _MOST_BETWEEN)
        behind, known = np.append(0.0, np.cumsum(parts)), np.arange(len(way))
        index = np.interp(np.arange(behind[-1] + 1), behind, known)
        nearest = self.nearest(interpolated(index, known, way))
        return nearest and dataclasses.replace(nearest, index=round(index[nearest.index]))

    def nearest(self, configurations: Array) -> Encroachment | None:
        """Where these configurations (k, C) come nearest to a region; None without regions."""
        if not len(self.plant.regions):
            return None
        return self.nearest_of(self.body_mm(configurations), self._body_arc_mm)

    def nearest_of(self, point_mm: Array, arc_mm: Array) -> Encroachment | None:
        """Where the points (k, m, 3) at these arc lengths (m,) come nearest to a region; None without regions."""
        if not len(self.plant.regions):
            return None
        distance, _ = self.plant.regions.clearance(point_mm)
        index, point, region = np.unravel_index(distance.argmin(), distance.shape)
        return Encroachment(
            index=int(index),
            spare_mm=float(distance[index, point, region]) - self.plant.clearance_mm,
            region=self.plant.regions.names[region],
            arc_mm=float(arc_mm[point]),
            point_mm=point_mm[index, point],
        )

    def sweep_mm(self, way: Array) -> Array:
        """(...) what no point of the body moves farther than when the configuration changes by (..., C)."""
        bend = (way[..., : 2 * self._sections] @ self._bend_of.T).reshape(*way.shape[:-1], self._sections, 2)
        swung = np.linalg.norm(bend, axis=-1) @ self._lever_mm
        sweep: Array = swung + np.abs(way[..., 2 * self._sections :]).sum(axis=-1)
        return sweep


def interpolated(at: Array | Count, known: Array | Count, configurations: Array) -> Array:
    """(k, C) at these places (k,), straight on between configurations (w, C) that are known at others (w,), which increase."""
    return np.stack([np.interp(at, known, column) for column in configurations.T], axis=-1)


def _arc(bend: Array, share: Array) -> Array:
    """(..., m, 3) points at these shares (m,) of an arc of length 1 bent by (..., 2) rad."""
    angle = share * np.linalg.norm(bend, axis=-1)[..., None]
    points = np.empty((*angle.shape, 3))
    # np.sinc(x) is sin(pi x) / (pi x); (1 - cos t) / t^2 is half the square of sinc at t / 2
    sideways = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * share**2
    points[..., :2] = sideways[..., None] * bend[..., None, :]
    points[..., 2] = np.sinc(angle / np.pi) * share
    return points


def _turn(bend: Array) -> Array:
    """(..., 3, 3) how the end of an arc is turned (Rodrigues' formula)."""
    angle = np.linalg.norm(bend, axis=-1)
    sinc, versine = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    turn = np.empty((*angle.shape, 3, 3))
    turn[..., :2, :2] = np.eye(2) - versine[..., None, None] * bend[..., :, None] * bend[..., None, :]
    turn[..., :2, 2] = sinc[..., None] * bend
    turn[..., 2, :2] = -turn[..., :2, 2]
    turn[..., 2, 2] = np.cos(angle)
    return turn
