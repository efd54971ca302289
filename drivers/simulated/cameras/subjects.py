"""What may stand before the cameras, from the opening of a shutter to its closing."""

from dataclasses import dataclass

from drivers.simulated.cameras.arrays import Array
from drivers.simulated.cameras.renderer import Renderer


@dataclass(frozen=True, kw_only=True)
class RobotInHolder:
    """The robot's centrelines (N, 3) in the robot frame when the shutter opened and when it closed."""

    opened_mm: Array
    closed_mm: Array

    def picture(self, renderer: Renderer) -> bytes:
        """What a camera sees of it."""
        return renderer.render(self.opened_mm, self.closed_mm)


@dataclass(frozen=True, kw_only=True)
class EmptyHolder:
    """The holder below a base at (3,) in the robot frame."""

    base_mm: Array

    def picture(self, renderer: Renderer) -> bytes:
        """What a camera sees of it."""
        return renderer.render_empty(self.base_mm)


@dataclass(frozen=True, kw_only=True)
class BoardBeforeHolder:
    """A board, and the empty holder behind it: `robot_from_board` (4, 4) when the shutter opened and when it closed."""

    base_mm: Array
    opened: Array
    closed: Array

    def picture(self, renderer: Renderer) -> bytes:
        """What a camera sees of it."""
        return renderer.render_board(self.base_mm, self.opened, self.closed)


Subject = RobotInHolder | EmptyHolder | BoardBeforeHolder
