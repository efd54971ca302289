"""The shape at the rate of a camera: the true centreline with noise, delay and drop-outs. Seeded; no images."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from controller.cycle import Sighting
from messaging.shape import ShapeEstimate
from nodal.virtual.settings import ShapeSettings

Array = NDArray[np.float64]

_NS_PER_S = 1_000_000_000
_NOTHING: Array = np.zeros(0)


class Seeing:
    """What sensing would say. Change `settings`, `lost`, `flags` or `refusal` at any moment; shapes under way still arrive."""

    def __init__(
        self,
        settings: ShapeSettings,
        length_mm: float,
        points: int,
        known_length_mm: float,
        start_s: float,
        seed: int,
    ) -> None:
        """For a centreline of `points` points, evenly spaced over the true `length_mm`; the first is taken after `start_s`."""
        self.settings = settings
        self.lost = False
        """No shape comes any more."""
        self.flags: tuple[str, ...] = ()
        self.refusal = ""
        self._arc_mm = np.linspace(0.0, length_mm, points)
        self._known_length_mm = known_length_mm
        self._random = np.random.default_rng(seed)
        self._sequence = 0
        self._due_s = start_s + float(self._random.random()) / settings.rate_hz
        self._coming: list[tuple[float, float, ShapeEstimate]] = []

    def nodes(self, centreline_mm: Array) -> Array:
        """(m, 3) where the nodal points truly are."""
        arc = np.asarray(self.settings.node_arc_mm)
        return np.column_stack([np.interp(arc, self._arc_mm, column) for column in centreline_mm.T])

    def look(self, before: tuple[float, Array], after: tuple[float, Array]) -> None:
        """Take every picture that is due between two moments (s) with their centrelines (N, 3)."""
        (before_s, old), (after_s, new) = before, after
        while self._due_s <= after_s:
            share = (self._due_s - before_s) / (after_s - before_s)
            self._take(self._due_s, old + share * (new - old))
            self._due_s += 1 / self.settings.rate_hz

    def arrived(self, now_s: float) -> Sighting | None:
        """The newest shape that has arrived since it was last asked."""
        here = [shape for shape in self._coming if shape[0] <= now_s]
        if not here:
            return None
        self._coming = [shape for shape in self._coming if shape[0] > now_s]
        _, capture_s, shape = max(here, key=lambda shape: shape[0])
        return Sighting(shape=shape, age_s=now_s - capture_s)

    def _take(self, capture_s: float, centreline_mm: Array) -> None:
        settings = self.settings
        # the same draws whatever is done with them, so that a change of one thing changes nothing else
        chance, wait = self._random.random(2)
        noise = self._random.normal(size=(len(settings.node_arc_mm), 3)) * settings.noise_mm
        self._sequence += 1
        if self.lost or chance < settings.dropped:
            return
        delay_s = max(settings.delay_s + settings.jitter_s * (2 * wait - 1), 0.0)
        shape = self._shape(capture_s, delay_s, centreline_mm, noise)
        self._coming.append((capture_s + delay_s, capture_s, self._refused(shape) if self.refusal else shape))

    def _shape(
        self, capture_s: float, delay_s: float, centreline_mm: Array, noise_mm: Array
    ) -> ShapeEstimate:
        node_arc, names = np.asarray(self.settings.node_arc_mm), self.settings.node_names
        along = np.column_stack([np.interp(self._arc_mm, [0.0, *node_arc], [0.0, *n]) for n in noise_mm.T])
        return ShapeEstimate(
            sequence=self._sequence,
            capture_time_ns=round(capture_s * _NS_PER_S),
            capture_to_publish_ns=round(delay_s * _NS_PER_S),
            refusal="",
            method="virtual",
            flags=self.flags,
            arc_mm=self._arc_mm,
            centreline_mm=centreline_mm + along,
            epipolar_angle_rad=_NOTHING,
            node_names=names,
            node_arc_mm=node_arc,
            node_mm=self.nodes(centreline_mm) + noise_mm,
            node_covariance_mm2=np.tile(self.settings.noise_mm**2 * np.eye(3), (len(names), 1, 1)),
            length_mm=float(self._arc_mm[-1]),
            known_length_mm=self._known_length_mm,
            insertion_mm=float(centreline_mm[0, 2]),
            ray_gap_mm=0.0,
            ray_bias_mm=0.0,
            residual_px=0.0,
            camera_names=(),
            camera_residual_px=_NOTHING,
            visible_mm=_NOTHING,
            stage_names=(),
            stage_s=_NOTHING,
        )

    def _refused(self, shape: ShapeEstimate) -> ShapeEstimate:
        return dataclasses.replace(
            shape,
            refusal=self.refusal,
            arc_mm=_NOTHING,
            centreline_mm=_NOTHING.reshape(0, 3),
            node_names=(),
            node_arc_mm=_NOTHING,
            node_mm=_NOTHING.reshape(0, 3),
            node_covariance_mm2=_NOTHING.reshape(0, 3, 3),
        )
