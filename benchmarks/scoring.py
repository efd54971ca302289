"""How exact estimates are, over many of them: errors, length, ray gaps, flags, and whether ellipsoids hold the truth."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from benchmarks.degradations.running import SILENT_MM, held_against
from benchmarks.poses import LENGTH_MM, Array
from sensing.errors import SensingError
from sensing.shape import Shape


@dataclass(frozen=True, eq=False)
class Held:
    """A shape against the truth: errors (8,) in mm of its nodal points, and which of them its 95 % ellipsoids hold."""

    error_mm: Array
    inside: Array
    length_per_10_mm: float
    ray_gap_mm: float
    flags: tuple[str, ...]


@dataclass
class Score:
    """Shapes held against the truth, and the reasons of those that there were none of. Figures are of shapes without a flag."""

    held: list[Held] = field(default_factory=list)
    refusals: list[str] = field(default_factory=list)

    def add(self, look: Callable[[], Shape], truth_mm: Array) -> str:
        """Look, and hold the shape against the true centreline (81, 3); says how it came out."""
        try:
            shape = look()
            error_mm, inside = held_against(shape, truth_mm)
        except SensingError as error:
            self.refusals.append(str(error))
            return f"refused: {error}"
        gap_mm, flags = shape.evidence.ray_gap_mm, tuple(map(str, shape.flags))
        length_per_10_mm = abs(shape.length_mm - LENGTH_MM) / (LENGTH_MM / 10)
        self.held.append(Held(error_mm, inside, length_per_10_mm, gap_mm, flags))
        return (
            f"mean {error_mm.mean():.3f}  max {error_mm.max():.3f}  tip {error_mm[-1]:.3f}  "
            f"length {shape.length_mm:.3f}  gap {gap_mm:.3f} mm  flags {', '.join(flags) or 'none'}"
        )

    @property
    def trusted(self) -> list[Held]:
        """The shapes that nothing speaks against."""
        return [one for one in self.held if not one.flags]

    @property
    def error_mm(self) -> Array:
        """Errors (n, 8) in mm."""
        return np.array([one.error_mm for one in self.trusted])

    @property
    def length_per_10_mm(self) -> Array:
        """Errors (n,) of the length, in mm per 10 mm."""
        return np.array([one.length_per_10_mm for one in self.trusted])

    @property
    def inside(self) -> float:
        """The share of nodal points whose 95 % ellipsoid holds the truth."""
        return float(np.mean([one.inside for one in self.trusted]))

    @property
    def silent(self) -> int:
        """How many are wrong although nothing says so."""
        return int(np.count_nonzero(self.error_mm.max(axis=1) > SILENT_MM)) if self.trusted else 0

    def lines(self) -> Iterator[str]:
        """What it comes to, and the errors of the shapes with each flag."""
        trusted, refused = len(self.trusted), len(self.refusals)
        yield (
            f"{len(self.held) + refused} estimates: {trusted} without a flag, {len(self.held) - trusted} flagged, "
            f"{refused} refused, {self.silent} wrong by more than {SILENT_MM:g} mm in silence"
        )
        if trusted:
            yield _figures("node error, mm", self.error_mm)
            yield _figures("tip error, mm", self.error_mm[:, -1])
            yield _figures("length error, mm per 10 mm", self.length_per_10_mm)
            yield _figures("ray gap, mm", np.array([one.ray_gap_mm for one in self.trusted]))
            yield f"  truth in the 95 % ellipsoid of {100 * self.inside:.1f} % of nodal points"
        for flag, times in Counter(flag for one in self.held for flag in one.flags).most_common():
            errors = np.array([one.error_mm for one in self.held if flag in one.flags])
            yield f"  {flag}: {times}, node error mean {errors.mean():.3f}, max {errors.max():.3f} mm"


def _figures(what: str, values: Array) -> str:
    return (
        f"  {what:<28} mean {values.mean():.4f}  p95 {np.percentile(values, 95):.4f}  max {values.max():.4f}"
    )
