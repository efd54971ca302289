"""Writing what a bench file says into its servos: EEPROM, id, baud rate, and what must not linger in RAM."""

import dataclasses
from collections.abc import Iterator, Mapping

from drivers.dynamixel import control_table as table
from drivers.dynamixel.axis import Axis
from drivers.dynamixel.bus import DynamixelBus
from drivers.dynamixel.commissioning import known_model
from drivers.dynamixel.control_table import Model, Register
from drivers.dynamixel.errors import NoAnswerError, UnconfirmedError
from drivers.dynamixel.feedback import ANSWER_EVERYTHING
from drivers.dynamixel.needs import eeprom_needs
from drivers.dynamixel.settings import AxisSettings, ServoSettings
from nodal.errors import BusError, CommandError, SetupRefusedError
from nodal.servos.port import Buses
from nodal.servos.scan import FoundServo, find
from nodal.servos.words import SHARED, value_words

_RAM: Mapping[Register, int] = {table.BUS_WATCHDOG: 0, table.LED: 0}
"""A watchdog that has stopped its servo refuses goals until it is cleared; the driver arms it with the torque."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Order:
    """What to set up: all axes, or the one called `axis`, whose servo has the id `from_id` so far.

    `relax` allows torque to be turned off; a `dry_run` writes nothing.
    """

    settings: ServoSettings
    axis: str | None = None
    from_id: int | None = None
    relax: bool = False
    dry_run: bool = False

    @property
    def axes(self) -> tuple[AxisSettings, ...]:
        """The axes that are meant; raises CommandError for a name that the bench does not have."""
        axes = tuple(axis for axis in self.settings.axes if self.axis in (None, axis.name))
        if not axes:
            names = ", ".join(axis.name for axis in self.settings.axes)
            raise CommandError(f"--axis {self.axis}: the bench has {names}")
        return axes


def set_up(buses: Buses, order: Order) -> Iterator[str]:
    """Find every servo, refuse what must not be, then write what differs, saying each change once it is confirmed.

    Raises CommandError, BusError, SetupRefusedError and WrongModelError with nothing written; PortError, StatusError,
    NoAnswerError and UnconfirmedError.
    """
    places = _places(buses, order)
    for axis, servo in places:
        with buses(servo.baud_rate) as bus:
            yield from _write(bus, servo, axis, order)
        yield from _move(buses, servo, axis.settings, order)


def _places(buses: Buses, order: Order) -> list[tuple[Axis, FoundServo]]:
    """Each axis with its servo, when all may be written."""
    now = {axis.name: axis.id if order.from_id is None else order.from_id for axis in order.axes}
    rates = tuple(dict.fromkeys((order.settings.baud_rate, *table.BAUD_RATES)))
    ids = sorted({*now.values(), *(axis.id for axis in order.axes)})
    found = find(buses, rates, ids)
    places = []
    for axis in order.axes:
        servos = [servo for servo in found if servo.id == now[axis.name]]
        if not servos:
            raise BusError(
                f"servo {now[axis.name]} ({axis.name}) does not answer at any baud rate; is it plugged in and powered?"
            )
        takers = [servo for servo in found if servo.id == axis.id]
        places.append((Axis(axis, _writable_model(axis, servos, takers, order), 0.0), servos[0]))
    return places


def _writable_model(
    axis: AxisSettings, servos: list[FoundServo], takers: list[FoundServo], order: Order
) -> Model:
    """The model of the axis' servo, when it may be written."""
    servo, name = servos[0], f"servo {servos[0].id} ({axis.name})"
    if servo.identity is None:
        raise SetupRefusedError(f"{name}: {SHARED}")
    if len(servos) > 1:
        rates = " and ".join(str(one.baud_rate) for one in servos)
        raise SetupRefusedError(f"{name}: one answers at {rates} baud each; connect them one at a time")
    if servo.id != axis.id and takers:
        raise SetupRefusedError(
            f"{name} cannot become {axis.id}: {takers[0].model_name} at {takers[0].baud_rate} baud has this id"
        )
    if servo.readings[table.TORQUE_ENABLE] and not order.relax:
        raise SetupRefusedError(
            f"{name}: torque is on, and EEPROM is locked; --relax allows to turn it off, which lets the tendon or the stage go"
        )
    return known_model(order.settings.port, axis, servo.identity)


def _write(bus: DynamixelBus, servo: FoundServo, axis: Axis, order: Order) -> Iterator[str]:
    """Every register that differs, each read back."""
    if not order.dry_run:
        bus.sync_write(table.STATUS_RETURN_LEVEL, {servo.id: ANSWER_EVERYTHING})
    shutdown = bus.read(servo.id, table.SHUTDOWN)
    needs = {table.TORQUE_ENABLE: 0, **eeprom_needs(axis, order.settings, shutdown), **_RAM}
    for register, needed in needs.items():
        found = bus.read(servo.id, register)
        if found == needed:
            continue
        if not order.dry_run:
            bus.write(servo.id, register, needed)
            again = bus.read(servo.id, register)
            if again != needed:
                raise UnconfirmedError(
                    f"{bus.port}: servo {servo.id}: {register.name} reads {again} after {needed} was written"
                )
        yield _change(axis.settings, servo.id, register, found, needed, axis.model)


def _move(buses: Buses, servo: FoundServo, axis: AxisSettings, order: Order) -> Iterator[str]:
    """Another id, then another baud rate; neither write can be acknowledged, so who answers afterwards is the proof."""
    settings, writing = order.settings, not order.dry_run
    if servo.id != axis.id:
        if writing:
            with buses(servo.baud_rate) as bus:
                bus.sync_write(table.ID, {servo.id: axis.id})
                _confirm(bus, axis, f"servo {servo.id} does not answer to its new id {axis.id}")
        yield f"servo {servo.id} ({axis.name}): ID {servo.id} -> {axis.id}"
    if servo.baud_rate != settings.baud_rate:
        if writing:
            with buses(servo.baud_rate) as bus:
                bus.sync_write(table.BAUD_RATE, {axis.id: table.BAUD_RATES.index(settings.baud_rate)})
            with buses(settings.baud_rate) as bus:
                _confirm(
                    bus,
                    axis,
                    f"servo {axis.id} does not answer at its new baud rate {settings.baud_rate}; can its model do that?",
                )
        yield f"servo {axis.id} ({axis.name}): Baud Rate {servo.baud_rate} -> {settings.baud_rate}"


def _confirm(bus: DynamixelBus, axis: AxisSettings, failure: str) -> None:
    try:
        bus.ping(axis.id)
    except NoAnswerError as error:
        raise UnconfirmedError(f"{bus.port}: {failure}: {error}") from error


def _change(axis: AxisSettings, servo: int, register: Register, found: int, needed: int, model: Model) -> str:
    before, after = (value_words(register, value, model) for value in (found, needed))
    return f"servo {servo} ({axis.name}): {register.name} {before} -> {after}"
