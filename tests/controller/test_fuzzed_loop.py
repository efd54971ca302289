"""The whole loop under orders, targets and troubles in any order: what must hold, holds in every single cycle."""

import copy
import dataclasses
import itertools

import numpy as np
import pytest

from controller.supervisor import Mode
from messaging.control import Action, ActionRequest, Target

PERIOD_S = 0.005
STEPS = 40
HOMED = {Mode.READY, Mode.TRACKING, Mode.HOLD, Mode.WAITING, Mode.RELAXING}
PAIRS = list(itertools.product((action for action in Action if action is not Action.STATUS), repeat=2))


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


def order(action, axis="1", distance_mm=1.0):
    return ActionRequest(action=Action(action), axis=axis, distance_mm=distance_mm)


def requests_of(random, stand_ins):
    """None, one or several, in any order."""
    chosen = [random.choice([*Action, *3 * USUAL]) for _ in range(random.integers(0, 3))]
    requests = [
        order(action, str(random.choice(["1", "4", "stage", "9"])), float(random.normal()))
        for action in chosen
    ]
    if random.random() < 0.3:
        requests.append(stand_ins["pose"]((random.uniform(-15, 15), random.uniform(-15, 15), 84.0)))
    return requests


def check_homing(before, now, outputs):
    """It ends in ready with the present place called zero, or in nothing that needs it."""
    if before.mode is Mode.HOMING and now.mode in HOMED:
        assert now.mode is Mode.READY
        assert outputs.zero_mm is not None
        assert not outputs.zero_mm[:4].any()
        assert not now.command_mm[:4].any()


def check_target(before, now, outputs, requests):
    """It is followed, told and forgotten as the replies say."""
    accepted = [
        request
        for request, reply in zip(requests, outputs.replies, strict=True)
        if isinstance(request, Target) and reply.accepted
    ]
    assert len(accepted) <= 1
    assert outputs.accepted in (None, *accepted)
    assert now.task is None or now.mode is Mode.HOMING or now.task.reference.target is now.target
    assert now.mode.torque or not before.mode.torque or now.target in (None, *accepted)
    assert now.target is not None or now.progress == now.joined_s == 0.0
    assert {reply.state for reply in outputs.replies} <= {now.mode.state}


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


def check(before, moment, requests, limits):
    """Everything that must hold in a cycle that led on from `before`."""
    now, outputs = moment.state, moment.outputs
    asked = zip(requests, outputs.replies, strict=True)
    orders = {r.action for r, reply in asked if isinstance(r, ActionRequest) and reply.accepted}
    check_torque(before, now, outputs, orders)
    check_modes(before, now, orders)
    check_homing(before, now, outputs)
    check_target(before, now, outputs, requests)
    check_command(before, outputs, limits)


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
        moments, _ = bench.run(float(random.choice([PERIOD_S, 0.1, 0.5])), *requests)
        for moment in moments:
            check(before, moment, requests, bench.loop._plant.limits)
            before, requests = moment.state, ()


@pytest.mark.parametrize("seed", range(3))
def test_it_holds_too_with_orders_in_every_cycle_until_homing_ends(seed, paper_bench, stand_ins):
    random = np.random.default_rng(seed)
    paper_bench.run(0.2)
    paper_bench.do("home")
    harmless = [action for action in Action if action not in (Action.STOP, Action.RELAX)]
    while (before := paper_bench.state).mode is Mode.HOMING:
        requests = [order(action) for action in random.choice(harmless, 2)]
        moment = paper_bench.cycle(requests)
        check(before, moment, requests, paper_bench.loop._plant.limits)
    assert moment.state.mode is Mode.READY


def begun(mode, paper_bench, homed, tracking):
    """A bench in this mode."""
    if mode in (Mode.IDLE, Mode.HOMING, Mode.UNHOMED):
        paper_bench.run(0.2)
        if mode is not Mode.IDLE:
            paper_bench.run(0.1, order("home" if mode is Mode.HOMING else "jog"))
        return paper_bench
    if mode is Mode.READY:
        return homed
    if mode is Mode.WAITING:
        blind(tracking)
        tracking.run(0.2)
    elif mode is Mode.FAULT:
        alarm(tracking)
        tracking.run(PERIOD_S)
        clear(tracking)
    elif mode is not Mode.TRACKING:
        tracking.do({Mode.HOLD: "hold", Mode.RELAXING: "relax"}[mode])
    return tracking


@pytest.mark.parametrize("mode", Mode)
def test_it_holds_after_any_two_orders_in_one_cycle(mode, paper_bench, homed, tracking):
    bench = begun(mode, paper_bench, homed, tracking)
    assert bench.state.mode is mode
    for pair in PAIRS:
        twin = copy.deepcopy(bench)
        requests = [order(action) for action in pair]
        for cycle in range(4):
            before, asked = twin.state, requests if cycle == 0 else ()
            check(before, twin.cycle(asked), asked, twin.loop._plant.limits)
