"""The whole loop under orders, targets and troubles in any order: what must hold, holds in every single cycle."""

import dataclasses

import numpy as np
import pytest

from controller.supervisor import Mode
from messaging.control import Action, ActionRequest

PERIOD_S = 0.005
STEPS = 40


def clear(bench):
    """Everything that a trouble spoilt is well again."""
    bench.drive_absent = ""
    bench.camera = lambda shape: shape
    servos = bench.servos
    servos.hardware_error, servos.current_ma, servos.voltage_v, servos.jammed = 0, 100.0, 12.0, False


def unplug(bench):
    bench.drive_absent = "unplugged"
    bench.servos.torque = False


def blind(bench):
    bench.camera = lambda _: None


def flag(bench):
    bench.camera = lambda shape: dataclasses.replace(shape, flags=("tip_unseen",))


def alarm(bench):
    bench.servos.hardware_error = 1


def overload(bench):
    bench.servos.current_ma = 2000.0


def jam(bench):
    bench.servos.jammed = True


def let_go(bench):
    bench.servos.torque = False


TROUBLES = (unplug, blind, flag, alarm, overload, jam, let_go)
USUAL = (
    Action.ARM,
    Action.ARM,
    Action.HOLD,
    Action.JOG,
    Action.PAUSE,
    Action.RESUME,
    Action.HOME,
    Action.HOME,
)


def requests_of(random, stand_ins):
    """None, one or several, in any order."""
    chosen = [random.choice([*Action, *3 * USUAL]) for _ in range(random.integers(0, 3))]
    requests = [
        ActionRequest(
            action=Action(action),
            axis=str(random.choice(["1", "4", "stage", "9"])),
            distance_mm=float(random.normal()),
        )
        for action in chosen
    ]
    if random.random() < 0.3:
        requests.append(stand_ins["pose"]((random.uniform(-15, 15), random.uniform(-15, 15), 84.0)))
    return requests


def check_torque(before, now, outputs, orders):
    """Torque comes by orders, and goes with a word to the servos."""
    assert (outputs.command_mm is not None) == now.mode.torque
    assert outputs.engage == (now.mode.torque and not before.mode.torque)
    assert not outputs.engage or orders & {Action.HOME, Action.JOG}
    assert outputs.release or not before.mode.torque or now.mode.torque
    assert Action.STOP not in orders or not now.mode.torque


def check_modes(before, now, orders):
    """Nothing is left or begun by itself, and what belongs to a mode is there in no other."""
    if before.mode is Mode.FAULT and now.mode is not Mode.FAULT:
        assert orders & {Action.HOME, Action.RELAX}
    if now.mode is Mode.TRACKING and before.mode not in (Mode.TRACKING, Mode.WAITING):
        assert Action.ARM in orders
    assert (now.supervision.fault is not None) == (now.mode is Mode.FAULT)
    assert now.jog is None or now.mode in (Mode.HOLD, Mode.UNHOMED)
    assert now.search is None or now.mode is Mode.HOMING
    assert not now.paused or now.mode in (Mode.TRACKING, Mode.WAITING)


def check_command(before, outputs, limits):
    """Within travel and, but where it gets a new name, within rate."""
    if outputs.command_mm is None:
        return
    assert np.isfinite(outputs.command_mm).all()
    assert (outputs.command_mm >= limits.low_mm).all()
    assert (outputs.command_mm <= limits.high_mm).all()
    step_mm = np.abs(outputs.command_mm - before.command_mm)
    assert outputs.zero_mm is not None or (step_mm <= limits.rate_mm_s * PERIOD_S + 1e-9).all()


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("begin", ["idle", "tracking"])
def test_what_must_hold_holds_in_every_cycle(seed, begin, paper_bench, tracking, stand_ins):
    random = np.random.default_rng(seed)
    bench = {"idle": paper_bench, "tracking": tracking}[begin]
    before = bench.state
    for _ in range(STEPS):
        clear(bench)
        if random.random() < 0.15:
            random.choice(TROUBLES)(bench)
        requests = requests_of(random, stand_ins)
        moments, replies = bench.run(float(random.choice([PERIOD_S, 0.1, 0.5])), *requests)
        asked = zip(requests, replies, strict=True)
        orders = {r.action for r, reply in asked if isinstance(r, ActionRequest) and reply.accepted}
        for moment in moments:
            check_torque(before, moment.state, moment.outputs, orders)
            check_modes(before, moment.state, orders)
            check_command(before, moment.outputs, bench.loop._plant.limits)
            before, orders = moment.state, set()
