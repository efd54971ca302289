"""What differs between the servos and the bench file, in words, each with what to do about it."""

import dataclasses
from collections.abc import Iterator, Mapping, Sequence

from drivers.dynamixel import control_table as table
from drivers.dynamixel.axis import Axis
from drivers.dynamixel.commissioning import known_model
from drivers.dynamixel.control_table import Register, hardware_error_names
from drivers.dynamixel.errors import WrongModelError
from drivers.dynamixel.needs import eeprom_needs
from drivers.dynamixel.settings import AxisSettings, ServoSettings
from nodal.servos.port import Buses
from nodal.servos.scan import EVERY_ID, FoundServo, find, scan
from nodal.servos.words import SHARED, value_words

_SET_UP = "run `nodal servos setup`"
_NEARLY_HOT_C = 10


@dataclasses.dataclass(frozen=True, kw_only=True)
class Seen:
    """What was read of a servo of the bench: who it is, and its EEPROM."""

    found: FoundServo
    eeprom: Mapping[Register, int]


def examine(buses: Buses, settings: ServoSettings) -> Iterator[str]:
    """Ask everybody at the bench's baud rate, seek who is missing at the others, and say what is wrong; raises PortError."""
    present = {servo.id: servo for servo in scan(buses, (settings.baud_rate,), EVERY_ID)}
    missing = [axis.id for axis in settings.axes if axis.id not in present]
    elsewhere = {servo.id: servo for servo in find(buses, table.BAUD_RATES, missing)} if missing else {}
    present |= {i: servo for i, servo in elsewhere.items() if servo.baud_rate == settings.baud_rate}
    with buses(settings.baud_rate) as bus:
        for axis in settings.axes:
            subject = f"servo {axis.id} ({axis.name})"
            if axis.id not in present:
                yield f"{subject}: {_absence(elsewhere.get(axis.id), settings)}"
                continue
            found, eeprom = present[axis.id], {}
            if found.alone:
                registers = (
                    *eeprom_needs_of(axis, found, settings, 0),
                    table.MIN_VOLTAGE_LIMIT,
                    table.MAX_VOLTAGE_LIMIT,
                )
                eeprom = {register: bus.read(axis.id, register) for register in registers}
            seen = Seen(found=found, eeprom=eeprom)
            yield from (f"{subject}: {fault}" for fault in faults(axis, seen, settings, bus.port))
    for servo in sorted(set(present) - {axis.id for axis in settings.axes}):
        yield (
            f"servo {servo}, {present[servo].model_name}, is no axis of the bench; take it off the bus, or give it to an axis: "
            f"`nodal servos setup --axis NAME --from-id {servo}`"
        )


def eeprom_needs_of(
    axis: AxisSettings, found: FoundServo, settings: ServoSettings, shutdown: int
) -> dict[Register, int]:
    """What the EEPROM of this servo should hold; nothing for a model that the bench cannot use."""
    model = table.MODELS.get(found.identity.model_number) if found.identity else None
    return eeprom_needs(Axis(axis, model, 0.0), settings, shutdown) if model else {}


def faults(axis: AxisSettings, seen: Seen, settings: ServoSettings, port: str) -> Sequence[str]:
    """What is wrong with one servo that answers, and what to do."""
    identity = seen.found.identity
    if identity is None:
        return [SHARED]
    try:
        model = known_model(port, axis, identity)
    except WrongModelError as error:
        return [f"{error}; exchange it, or update its firmware"]
    needs = eeprom_needs_of(axis, seen.found, settings, seen.eeprom[table.SHUTDOWN])
    return [
        *_state_faults(Axis(axis, model, axis.zero_ticks or 0.0), seen),
        *(
            f"{register.name} is {value_words(register, seen.eeprom[register], model)}, needed is "
            f"{value_words(register, needed, model)}; {_SET_UP}"
            for register, needed in needs.items()
            if seen.eeprom[register] != needed
        ),
    ]


def _state_faults(axis: Axis, seen: Seen) -> Iterator[str]:
    readings, settings = seen.found.readings, axis.settings
    if bits := readings[table.HARDWARE_ERROR_STATUS]:
        yield f"hardware error {hardware_error_names(bits)}; find the cause, then `nodal servos reboot {settings.id}`"
    if readings[table.TORQUE_ENABLE]:
        yield "torque is on though nobody controls it; `nodal servos setup --relax` lets it go"
    if readings[table.BUS_WATCHDOG] == table.WATCHDOG_EXPIRED:
        yield f"its watchdog has stopped it, since whoever controlled it fell silent; {_SET_UP}"
    volts, low, high = (
        count * table.VOLTS_PER_COUNT
        for count in (
            readings[table.PRESENT_INPUT_VOLTAGE],
            seen.eeprom[table.MIN_VOLTAGE_LIMIT],
            seen.eeprom[table.MAX_VOLTAGE_LIMIT],
        )
    )
    if not low <= volts <= high:
        yield f"its supply is {volts:.1f} V, allowed are {low:.1f} to {high:.1f} V; look at the power supply"
    degrees, limit = readings[table.PRESENT_TEMPERATURE], seen.eeprom[table.TEMPERATURE_LIMIT]
    if degrees > limit - _NEARLY_HOT_C:
        yield f"it is {degrees} C warm and lets go at {limit} C; let it cool"
    if settings.zero_ticks is not None:
        place_mm = axis.position_mm(readings[table.PRESENT_POSITION])
        if not settings.min_mm <= place_mm <= settings.max_mm:
            yield (
                f"it stands at {place_mm:.1f} mm, travel is {settings.min_mm:g} to {settings.max_mm:g} mm: it lost its turns "
                "with its supply, or zero_ticks is wrong; docs/servos.md says how to find it anew"
            )


def _absence(elsewhere: FoundServo | None, settings: ServoSettings) -> str:
    if elsewhere is not None:
        return f"speaks at {elsewhere.baud_rate} baud, the bench at {settings.baud_rate}; {_SET_UP}"
    return (
        "does not answer at any baud rate; is it plugged in and powered? A new servo has id 1: connect it alone, "
        "`nodal servos setup --axis NAME --from-id 1`"
    )
