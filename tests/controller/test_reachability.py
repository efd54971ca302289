"""What the robot cannot follow is refused before anything moves, with the number, what is allowed, the place and the moment."""

import dataclasses

import numpy as np
import pytest

from controller.errors import TooCloseError, TooFastError, UnknownNodeError, UnreachableError
from controller.plant import Plant
from controller.reachability import check_target
from controller.regions import HalfSpace, Sphere
from controller.settings import ControllerSettings, LimitSettings
from messaging.control import Target
from messaging.errors import InvalidMessageError

ARCS = {"middle": 40.0, "tip": 80.0}
LAMP = Sphere(name="lamp", centre_mm=(20.0, 0.0, 60.0), radius_mm=6.0)
WALL = HalfSpace(name="wall", point_mm=(0.0, 14.0, 0.0), normal=(0.0, -1.0, 0.0))


def checker(robot, settings):
    plant = Plant.of(settings, robot)
    return lambda target, **others: check_target(target, ARCS, plant, settings, **others)


@pytest.fixture
def check(stand_ins):
    return checker(stand_ins["ROBOT"], ControllerSettings())


@pytest.fixture
def check_beside(stand_ins):
    """A check with these forbidden regions."""
    return lambda *regions: checker(stand_ins["ROBOT"], ControllerSettings(forbidden=regions))


def led(time_s, places_mm, *, repeat=False, node="tip"):
    return Target(
        name="line",
        node_names=(node,),
        weights=[1.0],
        time_s=time_s,
        position_mm=np.reshape(places_mm, (-1, 1, 3)),
        repeat=repeat,
    )


def test_reachable_targets_pass(check, stand_ins):
    check(stand_ins["circle"]())
    check(stand_ins["circle"](radius_mm=25.0, z_mm=100.0, period_s=20.0))
    check(stand_ins["circle"](node="middle", radius_mm=5.0, z_mm=45.0))
    check(stand_ins["pose"]((0.0, 0.0, 80.0)))
    check(stand_ins["pose"]((0.0, 0.0, 75.0))), "though a straight robot has to bend to and fro for it"


@pytest.mark.parametrize(
    ("position", "message"),
    [
        (
            (0.0, 0.0, 130.0),
            r"tip at 0 s should be at \(0.0, 0.0, 130.0\) mm, 90.0 mm from .* stage travels 0 to 40",
        ),
        ((90.0, 0.0, 20.0), r"90.0 mm from the nearest place of the base; it lies 80.0 mm along the robot"),
        ((1.0, 0.0, 50.0), r"nearest that the model reaches is .* mm away \(allowed 1 mm\)"),
        ((0.0, 0.0, -70.0), r"tip at 0 s"),
    ],
)
def test_unreachable_points_are_named_with_distance_and_reach(check, stand_ins, position, message):
    with pytest.raises(UnreachableError, match=message):
        check(stand_ins["pose"](position))


def test_names_and_jumps(check, stand_ins):
    with pytest.raises(UnknownNodeError, match="no nodal point elbow; sensing reports middle, tip"):
        check(stand_ins["pose"]((0.0, 0.0, 80.0), node="elbow"))
    with pytest.raises(TooFastError, match=r"jumps by 10.0 mm where the path repeats"):
        check(led([0, 2], [(0, 0, 84), (10, 0, 84)], repeat=True))
    later = dataclasses.replace(
        led([0, 2, 4, 6], [(0, 0, 84), (10, 0, 84), (5, 0, 84), (10, 0, 84)], repeat=True), repeat_from_s=2.0
    )
    check(later)
    with pytest.raises(InvalidMessageError, match="not finite"):
        stand_ins["pose"]((0.0, np.nan, 80.0))


def test_speed_counts_as_it_is_between_the_moments_too(check, stand_ins):
    with pytest.raises(TooFastError, match=r"tip moves at 94.* mm/s .* at most 20 mm/s"):
        check(stand_ins["circle"](period_s=1.0))
    # 16 mm/s on average, but there and back it has to stop at every moment
    zigzag = led(np.arange(6.0), [(8.0 * (-1) ** n, 0.0, 84.0) for n in range(6)])
    with pytest.raises(TooFastError, match=r"moves at 24.0 mm/s at 1.5 s; at most 20 mm/s"):
        check(zigzag)


def test_a_short_dash_in_a_long_path_is_found(check):
    times = np.arange(0.0, 200.0, 0.5)
    places = np.stack([0 * times, 0 * times, 84 + 0.01 * times], axis=-1)
    places[123, 0] = 12.0
    with pytest.raises(TooFastError, match=r"at 61\.\d+ s"):
        check(led(times, places))


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"displacement_mm_s": 0.2}, r"tendon \d would have to move at 0\.\d mm/s at .* at most 0.2 mm/s"),
        ({"insertion_mm_s": 0.5}, None),
    ],
)
def test_axes_that_would_have_to_hurry_are_named(stand_ins, limits, message):
    slow = checker(stand_ins["ROBOT"], ControllerSettings(limits=LimitSettings(**limits)))
    upwards = led([0, 4], [(0.0, 0.0, 84.0), (0.0, 0.0, 94.0)])
    if message is None:
        message = r"stage would have to move at 2\.\d mm/s at .* at most 0.5 mm/s are allowed, so it must take 4\.\d+ times"
        target = upwards
    else:
        target = stand_ins["circle"]()
    with pytest.raises(TooFastError, match=message):
        slow(target)


def test_work_is_shared_where_one_axis_alone_would_be_too_slow(stand_ins):
    """Sideways motion of the tip takes the first section's tendon or the second's, or a little of both."""
    sideways = led([0, 1], [(0.0, 0.0, 85.0), (0.5, 0.0, 85.0)])
    for rate_mm_s, allowed in ((0.06, True), (0.01, False)):
        check = checker(
            stand_ins["ROBOT"], ControllerSettings(limits=LimitSettings(displacement_mm_s=rate_mm_s))
        )
        if allowed:
            check(sideways)
        else:
            with pytest.raises(TooFastError, match="tendon"):
                check(sideways)


def test_the_whole_body_keeps_clear(check_beside, stand_ins):
    with pytest.raises(TooCloseError, match=r"2\.\d mm from region lamp 80 mm along .* it keeps 5 mm away"):
        check_beside(LAMP)(stand_ins["pose"]((20.0, 0.0, 68.5)))
    # the tip is far from the pole that the middle would have to go through
    pole = Sphere(name="pole", centre_mm=(0.0, 0.0, 45.0), radius_mm=15.0)
    with pytest.raises(TooCloseError, match=r"region pole \d+ mm along its body"):
        check_beside(pole)(stand_ins["pose"]((0.0, 0.0, 80.0)))
    check_beside(LAMP)(stand_ins["pose"]((-17.0, 0.0, 75.0)))


def test_a_path_with_a_clear_way_to_reach_it_is_not_refused_for_another(check_beside, stand_ins):
    """Bent one way for half of this circle and the other way for the rest, the body would come through the knob."""
    lamp = Sphere(name="lamp", centre_mm=(30.0, 30.0, 60.0), radius_mm=10.0)
    knob = Sphere(name="knob", centre_mm=(0.0, -30.0, 40.0), radius_mm=10.0)
    check_beside(lamp, knob)(stand_ins["circle"](radius_mm=15.0, z_mm=70.0, period_s=40.0))


def test_the_moment_of_a_path_that_comes_too_near_is_told(check_beside, stand_ins):
    # the circle is nearest to the wall a quarter of its ten seconds after its beginning
    with pytest.raises(
        TooCloseError, match=r"at 2\.\d+ s the robot would be 1.0 mm inside region wall 80 mm along"
    ):
        check_beside(WALL)(stand_ins["circle"]())


def test_the_straight_way_to_the_beginning_counts(check_beside, stand_ins):
    """From one side of the lamp to its other."""
    lamp = Sphere(name="lamp", centre_mm=(0.0, 12.0, 85.0), radius_mm=3.0)
    check, target = check_beside(lamp), stand_ins["pose"]((12.0, 12.0, 85.0))
    check(target)
    check(target, start_mm=np.array([[12.0, -5.0, 86.0]]))
    with pytest.raises(TooCloseError, match=r"on the straight way to its beginning .* region lamp .* --plan"):
        check(target, start_mm=np.array([[-12.0, 12.0, 85.0]]))


def test_watched_points_may_be_anywhere(check):
    watched = Target(
        name="watched",
        node_names=("tip", "middle"),
        weights=[1.0, 0.0],
        time_s=[0.0],
        position_mm=[[[5.0, 0.0, 82.0], [999.0, 0.0, 0.0]]],
        repeat=False,
    )
    check(watched)
