"""The udev rules hold to udev's grammar and to what the driver and the units count on."""

import re
from pathlib import Path

import pytest

RULES = [
    line
    for line in (Path(__file__).parents[2] / "systemd" / "70-nodal-servos.rules").read_text().splitlines()
    if line and not line.startswith("#")
]
MATCHED = {"SUBSYSTEM", "ACTION", "DRIVER", "ATTRS{idVendor}", "ATTRS{idProduct}"}
ASSIGNED = {"SYMLINK": "+=", "GROUP": "=", "MODE": "=", "ATTR{latency_timer}": "="}
TERM = re.compile(r'([A-Z]+(?:\{\w+\})?)(==|\+=|=)"([^"]*)"')


def terms(rule):
    return [TERM.fullmatch(term).groups() for term in rule.split(", ")]


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_matches_first_and_assigns_then(rule):
    operators = [operator == "==" for _, operator, _ in terms(rule)]
    assert operators == sorted(operators, reverse=True)
    assert not all(operators)


@pytest.mark.parametrize("rule", RULES)
def test_keys_are_udevs_and_go_with_their_operators(rule):
    for key, operator, _ in terms(rule):
        assert (operator == "==" and key in MATCHED) or ASSIGNED.get(key) == operator


@pytest.mark.parametrize("rule", RULES)
def test_only_the_servo_adapter_is_touched(rule):
    matched = {key: value for key, operator, value in terms(rule) if operator == "=="}
    assert (matched["ATTRS{idVendor}"], matched["ATTRS{idProduct}"]) == ("0403", "6014")


def test_the_adapter_is_named_reachable_and_quick():
    assigned = {key: value for rule in RULES for key, operator, value in terms(rule) if operator != "=="}
    assert assigned == {
        "SYMLINK": "nodal-servos",
        "GROUP": "dialout",
        "MODE": "0660",
        "ATTR{latency_timer}": "1",
    }
