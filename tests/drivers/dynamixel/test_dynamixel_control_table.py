"""The driver's table against an independent one, and values against the sizes of their registers."""

import pytest
import rustypot

from drivers.dynamixel import control_table
from drivers.dynamixel.control_table import Access, Register

REGISTERS = [value for value in vars(control_table).values() if isinstance(value, Register)]


@pytest.mark.parametrize("register", REGISTERS, ids=lambda register: register.name)
def test_registers_stand_where_a_published_client_expects_them(register):
    theirs = rustypot.Xl330PyController.register(register.name.lower().replace(" ", "_"))
    assert (theirs.addr, theirs.size) == (register.address, register.size)
    says_minus_one_when_expired = register is control_table.BUS_WATCHDOG  # e-manual; they read it as 255
    assert register.signed == (theirs.encoding == "twos_complement" or says_minus_one_when_expired)


def test_no_two_registers_overlap():
    used = [place for r in REGISTERS for place in range(r.address, r.address + r.size)]
    assert len(used) == len(set(used))


def test_signed_registers_are_signed():
    assert control_table.PRESENT_POSITION.from_bytes(b"\xff\xff\xff\xff") == -1
    assert control_table.PRESENT_CURRENT.from_bytes(b"\x00\x80") == -32768
    assert control_table.BUS_WATCHDOG.from_bytes(b"\xff") == -1
    assert control_table.GOAL_POSITION.to_bytes(-2) == b"\xfe\xff\xff\xff"
    assert control_table.HARDWARE_ERROR_STATUS.from_bytes(b"\xff") == 255


@pytest.mark.parametrize(("register", "value"), [(control_table.TORQUE_ENABLE, 256), (control_table.ID, -1)])
def test_values_too_large_for_a_register_are_refused(register, value):
    with pytest.raises(OverflowError):
        register.to_bytes(value)


def test_what_is_only_reported_is_read_only():
    assert all(r.access is Access.READ for r in REGISTERS if r.name.startswith("Present"))


def test_hardware_errors_are_named():
    assert control_table.hardware_error_names(0x24) == "overheating, overload"
    assert control_table.hardware_error_names(0x40) == "bit 6"
