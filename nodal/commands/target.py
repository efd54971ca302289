"""`nodal target`: where nodal points should go. Targets are checked, and answered, before anything moves."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nodal.arguments import add_config_argument, add_timeout_argument
from nodal.exit_status import refused
from nodal.target_arguments import TIMINGS, add_kind, add_pace, add_weight, named, numbers

if TYPE_CHECKING:
    from controller.planning.space import Space
    from nodal.bench_settings import BenchSettings
    from nodal.targets.preparing import Asked
    from nodal.targets.present import Present

_EASY = 0.5
"""Share of the highest speed that a motion takes when nothing was said of how fast."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """One subcommand for each kind of target."""
    add_config_argument(parser)
    add_timeout_argument(parser)
    kinds = parser.add_subparsers(required=True, metavar="KIND")

    point = add_kind(
        kinds, "point", "hold nodal points at places", "tip=10,0,82 middle=3,0,42 --weight middle=0.2"
    )
    point.add_argument("places", nargs="+", type=named(3), metavar="NAME=X,Y,Z")
    add_weight(point)
    add_pace(point, "without one of these, points go straight there as fast as the bench file allows")
    point.set_defaults(asked=_point)

    jog = add_kind(kinds, "jog", "move one nodal point by so much from where it is", "tip +5,0,0")
    jog.add_argument("node", metavar="NAME")
    jog.add_argument("by", type=numbers(3), metavar="DX,DY,DZ")
    add_pace(jog)
    jog.set_defaults(asked=_jog)

    line = add_kind(kinds, "line", "lead one nodal point along a line", "tip 10,0,85 -10,0,85 --duration 4")
    line.add_argument("node", metavar="NAME")
    line.add_argument("start", type=numbers(3), metavar="X,Y,Z")
    line.add_argument("end", type=numbers(3), metavar="X,Y,Z")
    line.add_argument("--repeat", action="store_true", help="there and back, again and again")
    add_pace(line)
    line.set_defaults(asked=_line)

    spline = add_kind(
        kinds, "spline", "lead one nodal point along a smooth curve", "tip 10,0,85 0,10,88 -10,0,85"
    )
    spline.add_argument("node", metavar="NAME")
    spline.add_argument("places", nargs="+", type=numbers(3), metavar="X,Y,Z", help="three or more")
    spline.add_argument(
        "--closed", action="store_true", help="back to the first, again and again, at one speed"
    )
    add_pace(spline)
    spline.set_defaults(asked=_spline)

    circle = add_kind(kinds, "circle", "lead one nodal point round a circle", "tip --radius 10 --axis 0,1,4")
    circle.add_argument("node", metavar="NAME")
    circle.add_argument("--radius", type=float, default=15.0, metavar="MM", help="default 15")
    circle.add_argument(
        "--period", type=float, metavar="S", help="of one round; default 10, or as fast as it goes"
    )
    circle.add_argument("--height", type=float, default=85.0, metavar="MM", help="of the centre; default 85")
    circle.add_argument("--centre", type=numbers(2), default=[0.0, 0.0], metavar="X,Y", help="default 0,0")
    circle.add_argument(
        "--axis",
        type=numbers(3),
        default=[0.0, 0.0, 1.0],
        metavar="X,Y,Z",
        help="tilts it; default 0,0,1: level",
    )
    circle.set_defaults(asked=_circle)

    path = add_kind(
        kinds, "file", "a path from a CSV file: time_s,NAME.x,NAME.y,NAME.z,... in s and mm", "path.csv"
    )
    path.add_argument("file", type=Path, metavar="CSV")
    path.add_argument("--repeat", action="store_true", help="begin again when the end is reached")
    add_weight(path)
    path.set_defaults(asked=_path)


def run(arguments: argparse.Namespace) -> int:
    """Have the target followed: 0 when it is accepted (with --wait: when it has arrived), 3 when it is refused or fails."""
    from controller.errors import TargetError  # noqa: PLC0415
    from controller.planning.space import Space  # noqa: PLC0415
    from controller.plant import Plant  # noqa: PLC0415
    from nodal.bench_file import read_bench  # noqa: PLC0415

    bench = read_bench(arguments.config).checked()
    space = Space(Plant.of(bench.controller, bench.robot))
    asked: Asked = arguments.asked(arguments, _EASY * bench.controller.maximum_node_speed_mm_s)
    try:
        if arguments.check:
            return _checked(asked, arguments, bench, space)
        return _sent(asked, arguments, bench, space)
    except TargetError as error:
        return refused(error)


def _checked(asked: "Asked", arguments: argparse.Namespace, bench: "BenchSettings", space: "Space") -> int:
    from nodal.targets.preparing import prepared, summary  # noqa: PLC0415
    from nodal.targets.present import Present  # noqa: PLC0415

    present = Present.straight(bench, space)
    ready = prepared(asked, present, space.plant, bench.controller, planned=arguments.plan)
    print(f"target {ready.target.name} can be reached from {present.words}; nothing was moved")
    print("\n".join([*ready.notes, summary(ready.target, present, space.plant, bench.controller)]))
    return 0


def _sent(asked: "Asked", arguments: argparse.Namespace, bench: "BenchSettings", space: "Space") -> int:
    from messaging.session import open_session  # noqa: PLC0415
    from messaging.topics import CONTROLLER_TARGET  # noqa: PLC0415
    from nodal.asking import answer, tell  # noqa: PLC0415
    from nodal.errors import CommandError  # noqa: PLC0415
    from nodal.targets.following import follow  # noqa: PLC0415
    from nodal.targets.preparing import prepared  # noqa: PLC0415
    from nodal.targets.present import Present  # noqa: PLC0415

    with open_session(bench.zenoh, bench.name, "operator") as session:
        present = Present.on(session, space, arguments.timeout)
        ready = prepared(asked, present, space.plant, bench.controller, planned=arguments.plan)
        if arguments.wait and ready.target.repeat:
            raise CommandError(f"target {ready.target.name} repeats for ever; --wait would never end")
        reply = answer(session, CONTROLLER_TARGET, ready.target, arguments.timeout)
        status = tell(reply, "\n".join(ready.notes))
        if arguments.wait and reply.accepted:
            return follow(session, ready.target.name, arguments.timeout)
    return status


def _point(arguments: argparse.Namespace, easy_mm_s: float) -> "Asked":
    from nodal import targets  # noqa: PLC0415
    from nodal.targets.preparing import moved  # noqa: PLC0415

    target = targets.points(dict(arguments.places), _weights(arguments))
    if arguments.duration is None and arguments.speed is None and arguments.acceleration is None:
        return _asked(arguments, lambda _: target, timing_is_ours=True)
    pace = _pace(arguments, easy_mm_s)
    return _asked(arguments, lambda present: moved(target, present, pace), timing_is_ours=not pace.fixed)


def _jog(arguments: argparse.Namespace, easy_mm_s: float) -> "Asked":
    from nodal.targets.preparing import jogged  # noqa: PLC0415

    pace = _pace(arguments, easy_mm_s)
    return _asked(
        arguments,
        lambda present: jogged(arguments.node, arguments.by, present, pace),
        timing_is_ours=not pace.fixed,
    )


def _line(arguments: argparse.Namespace, easy_mm_s: float) -> "Asked":
    from nodal import targets  # noqa: PLC0415

    pace = _pace(arguments, easy_mm_s)
    target = targets.line(arguments.node, arguments.start, arguments.end, pace, repeat=arguments.repeat)
    return _asked(arguments, lambda _: target, timing_is_ours=not pace.fixed)


def _spline(arguments: argparse.Namespace, easy_mm_s: float) -> "Asked":
    from nodal import targets  # noqa: PLC0415

    pace = _pace(arguments, easy_mm_s)
    target = targets.spline(arguments.node, arguments.places, pace, closed=arguments.closed)
    return _asked(arguments, lambda _: target, timing_is_ours=not pace.fixed)


def _circle(arguments: argparse.Namespace, _: float) -> "Asked":
    from nodal import targets  # noqa: PLC0415

    target = targets.circle(
        arguments.node,
        radius_mm=arguments.radius,
        period_s=10.0 if arguments.period is None else arguments.period,
        height_mm=arguments.height,
        centre_mm=tuple(arguments.centre),
        axis=tuple(arguments.axis),
    )
    return _asked(arguments, lambda _: target, timing_is_ours=arguments.period is None)


def _path(arguments: argparse.Namespace, _: float) -> "Asked":
    from nodal import targets  # noqa: PLC0415

    target = targets.path(arguments.file, _weights(arguments), repeat=arguments.repeat)
    return _asked(arguments, lambda _: target, timing_is_ours=False)


def _asked(
    arguments: argparse.Namespace, make: "Callable[[Present], Any]", *, timing_is_ours: bool
) -> "Asked":
    from controller.planning.timing import Timing  # noqa: PLC0415
    from nodal.targets.preparing import Asked  # noqa: PLC0415

    timing = Timing(getattr(arguments, "timing", TIMINGS[0]))
    return Asked(
        make=make,
        timing_is_ours=timing_is_ours,
        timing=timing,
        acceleration_mm_s2=getattr(arguments, "acceleration", None),
    )


def _pace(arguments: argparse.Namespace, easy_mm_s: float) -> Any:
    from controller.planning.timing import Timing  # noqa: PLC0415
    from nodal.targets.pace import Pace  # noqa: PLC0415

    return Pace(
        duration_s=arguments.duration,
        speed_mm_s=arguments.speed,
        acceleration_mm_s2=arguments.acceleration,
        timing=Timing(arguments.timing),
        easy_mm_s=easy_mm_s,
    )


def _weights(arguments: argparse.Namespace) -> dict[str, float]:
    return {name: weight for name, (weight,) in arguments.weight}
