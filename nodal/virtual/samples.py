"""What was asked and what happened, at each step of the robot."""

import dataclasses
from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """n moments of a run, c cycles of the controller apart. A nodal point that nobody leads has nan as desired."""

    now_s: Array
    """(n,) virtual time."""
    desired_mm: Array
    """(n, m, 3)."""
    node_mm: Array
    """(n, m, 3) the true nodal points."""
    command_mm: Array
    """(n, c, A) in this cycle and the following ones; nan while the drive is told nothing."""
    current_ma: Array
    """(n, A)."""
    tension_N: Array
    """(n, T)."""
    torque: NDArray[np.bool_]
    """(n,) whether any servo drives its motor."""
    mode: tuple[str, ...]
    reason: tuple[str, ...]
    node_names: tuple[str, ...]

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """One after the other."""
        arrays = ("now_s", "desired_mm", "node_mm", "command_mm", "current_ma", "tension_N", "torque")
        return cls(
            **{name: np.concatenate([getattr(part, name) for part in parts]) for name in arrays},
            mode=tuple(mode for part in parts for mode in part.mode),
            reason=tuple(reason for part in parts for reason in part.reason),
            node_names=parts[0].node_names,
        )

    def error_mm(self, node: str) -> Array:
        """(n,) how far a nodal point is from where it should be; nan while nobody leads it."""
        index = self.node_names.index(node)
        error_mm: Array = np.linalg.norm(self.node_mm[:, index] - self.desired_mm[:, index], axis=1)
        return error_mm

    def to_bytes(self) -> bytes:
        """Everything, to compare runs by."""
        values = [getattr(self, field.name) for field in dataclasses.fields(self)]
        return b"".join(v.tobytes() if isinstance(v, np.ndarray) else repr(v).encode() for v in values)
