"""The controls of one camera: their values, and the ioctls that ask for them and set them."""

import errno
import os
from collections.abc import Sequence

from linuxpy.video import raw

from drivers.simulated.v4l2.description import ControlDescription

ENUMERATING = raw.ControlFlag.NEXT_CTRL | raw.ControlFlag.NEXT_COMPOUND


class Controls:
    """What each is `described` as, and holds; `refused` maps a control to the error number it answers with, `stubborn` one to
    the value that it always has.
    """

    def __init__(self, described: Sequence[ControlDescription]) -> None:
        self.described = {int(control.id): control for control in sorted(described, key=lambda one: one.id)}
        self.values: dict[int, int] = {}
        self.reset()
        self.refused: dict[int, int] = {}
        self.stubborn: dict[int, int] = {}

    def reset(self) -> None:
        """As from the factory."""
        self.values |= {number: control.default for number, control in self.described.items()}

    def query(self, asked: raw.v4l2_query_ext_ctrl) -> None:
        """VIDIOC_QUERY_EXT_CTRL."""
        if asked.id & ENUMERATING:
            control = next(
                (one for number, one in self.described.items() if number > asked.id & ~ENUMERATING), None
            )
        else:
            control = self.described.get(asked.id)
        if control is None:
            raise _refusal(errno.EINVAL)
        asked.id, asked.type, asked.name = control.id, control.type, control.name.encode()
        asked.minimum, asked.maximum = control.minimum, control.maximum
        asked.step, asked.default_value = control.step, control.default
        asked.flags = raw.ControlFlag.INACTIVE if self._is_automatic(control) else 0
        asked.elem_size, asked.elems, asked.nr_of_dims = 4, 1, 0

    def menu(self, asked: raw.v4l2_querymenu) -> None:
        """VIDIOC_QUERYMENU."""
        name = self._known(asked.id).menu.get(asked.index)
        if name is None:
            raise _refusal(errno.EINVAL)
        asked.name = name.encode()

    def get(self, asked: raw.v4l2_ext_controls) -> None:
        """VIDIOC_G_EXT_CTRLS."""
        for control in (asked.controls[index] for index in range(asked.count)):
            described = self._known(control.id)
            defaults = asked.which == raw.ControlWhichValue.DEF_VAL
            control.value = described.default if defaults else self.values[control.id]

    def set(self, asked: raw.v4l2_ext_controls) -> None:
        """VIDIOC_S_EXT_CTRLS: numbers are rounded to steps and brought into the range, menu entries must be there."""
        for control in (asked.controls[index] for index in range(asked.count)):
            described = self._known(control.id)
            if control.id in self.refused:
                raise _refusal(self.refused[control.id])
            if self._is_automatic(described):
                raise _refusal(errno.EACCES)
            if described.menu and control.value not in described.menu:
                raise _refusal(errno.EINVAL)
            steps = round((control.value - described.minimum) / described.step)
            value = min(max(described.minimum + steps * described.step, described.minimum), described.maximum)
            self.values[control.id] = self.stubborn.get(control.id, value)

    def _known(self, number: int) -> ControlDescription:
        if number not in self.described:
            raise _refusal(errno.EINVAL)
        return self.described[number]

    def _is_automatic(self, control: ControlDescription) -> bool:
        return control.automatic is not None and self.values[control.automatic] != control.manual


def _refusal(number: int) -> OSError:
    return OSError(number, os.strerror(number))
