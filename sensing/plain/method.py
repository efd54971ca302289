"""The paper's steps one after another."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from sensing.errors import RefusedError
from sensing.pictures.picture import Picture
from sensing.refined.track import Track
from sensing.scene import Scene
from sensing.settings import MethodName
from sensing.shape import Shape


@dataclass(frozen=True)
class Plain:
    """Every set of pictures by itself; the set before is of no use to it."""

    name: ClassVar[MethodName] = MethodName.PLAIN

    scene: Scene

    def estimate(
        self,
        pictures: Mapping[str, Picture],
        insertion_mm: float,
        last: Track | None,
        clock: Callable[[], float],
    ) -> Shape:
        """See `sensing.method.Method`."""
        raise RefusedError("not there yet")
