"""Settings of the emulated servo bus, and the faults it can be told to show."""

from typing import Annotated

import msgspec

from drivers.simulated.servos.memory import BAUD_RATES

Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
ServoId = Annotated[int, msgspec.Meta(ge=0, le=252)]
Numbers = frozenset[Annotated[int, msgspec.Meta(ge=1)]]


class MotorSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Motor and gear as seen at the horn; the defaults are an XM430-W350 at 12 V (e-manual: stall 4.1 Nm at 2.3 A,
    no load 46 rev/min), with the inertia of its rotor behind a 353.5:1 gear.
    """

    stall_torque_Nm: Positive = 4.1
    stall_current_A: Positive = 2.3
    no_load_speed_rad_s: Positive = 4.82
    supply_V: Positive = 12.0
    inertia_kg_m2: Positive = 0.012
    friction_Nm: NotNegative = 0.08
    ambient_C: Annotated[float, msgspec.Meta(ge=-5, le=60)] = 28.0
    overload_current_A: Positive = 2.0
    overload_s: Positive = 1.0
    """For how long it takes `overload_current_A` or more before it reports an overload."""


class EmulatedServosSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Servos on one bus behind a pty, reached at `link`. They start with factory settings, but for the mode and
    the delay that a bench's servos need to be opened.
    """

    link: Annotated[str, msgspec.Meta(min_length=1)]
    ids: Annotated[tuple[ServoId, ...], msgspec.Meta(min_length=1)]
    model_number: Annotated[int, msgspec.Meta(ge=0, le=65535)] = 1020
    firmware: Annotated[int, msgspec.Meta(ge=0, le=255)] = 48
    baud_rate: Annotated[int, msgspec.Meta(ge=9_600, le=4_500_000)] = 1_000_000
    """What they speak at first: a client at another speed is not heard."""
    operating_mode: Annotated[int, msgspec.Meta(ge=0, le=16)] = 5
    return_delay_us: Annotated[int, msgspec.Meta(ge=0, le=508)] = 0
    reboot_s: NotNegative = 0.2
    motor: MotorSettings = MotorSettings()

    def __post_init__(self) -> None:
        """Check what the bounds of single fields cannot say."""
        if len(set(self.ids)) != len(self.ids):
            raise ValueError(f"ids {list(self.ids)}: every servo needs an id of its own")
        if self.baud_rate not in BAUD_RATES:
            raise ValueError(f"baud_rate {self.baud_rate}: servos speak at {', '.join(map(str, BAUD_RATES))}")


class Faults(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What goes wrong on the bus: instructions and answers by number, counted from 1 since the faults were set, and servos by id.

    What becomes of an answer is told in the order of these fields: one that is dropped is not doubled.
    """

    unheard: Numbers = frozenset()
    """Instructions that reach nobody."""
    drop: Numbers = frozenset()
    truncate: Numbers = frozenset()
    corrupt: Numbers = frozenset()
    noise: Numbers = frozenset()
    """Answers behind `noise_bytes`."""
    noise_bytes: bytes = b"\x00\xff\xff\xfd\xfd\x5a"
    double: Numbers = frozenset()
    """Answers that come twice, the second time `double_after_s` later."""
    double_after_s: NotNegative = 0.0
    delay: Numbers = frozenset()
    delay_s: NotNegative = 0.05
    silent: frozenset[ServoId] = frozenset()
