"""The `nodal` command. Each subcommand is a file of nodal/commands, imported only when it is asked for."""

import argparse
import importlib
import os
import sys
from collections.abc import Sequence

from messaging.errors import NodalError
from nodal.arithmetic import pin
from nodal.exit_status import ERROR, INTERRUPTED

COMMANDS = {
    "new": "make the folder of a bench to begin with, real or simulated",
    "demo": "bring up the whole bench, drive the tip along a circle, and report",
    "estimate": "the robot's shape from still images, without a running bench",
    "do": "ask the controller: home, arm, hold, pause, resume, abort, jog, relax, stop, status; or watch it",
    "target": "send nodal points to a place, along a circle or along a path",
    "nodes": "name other nodal points while sensing runs",
    "replay": "run sensing and the controller over recordings again, and compare",
    "rendezvous": "run the meeting point of a bench's processes",
    "simulate": "run the simulated bench: cameras, servos and robot",
    "sense": "run shape sensing",
    "control": "run the controller",
    "cameras": "list cameras, write them into a bench file, look at their pictures and judge them",
    "calibrate": "bring a bench up: board, cameras, robot frame, background, robot",
    "calibration": "show, check and convert what was calibrated",
    "servos": "list, identify, set up and check the servos on a bus",
    "record": "run the recorder, or ask one that runs: start, stop, save, status",
    "report": "one page on a recording, or on several side by side",
    "log": "look into recordings, check, recover, cut, export and plot them",
}

BENCH_MODULES = {
    "cv2",
    "foxglove_schemas_protobuf",
    "linuxpy",
    "lz4",
    "mcap",
    "mcap_protobuf",
    "rich",
    "scipy",
    "tomlkit",
    "yaml",
    "zenoh",
}
"""What the extra `bench` brings; a base install embeds the controller and lacks them."""


def main(words: Sequence[str] | None = None) -> int:
    """Run one subcommand; returns the exit status: 0 done, 2 an error, 3 refused, 130 interrupted."""
    words = sys.argv[1:] if words is None else words
    pin()
    try:
        arguments = _parser(words).parse_args(words)
        status: int = arguments.run(arguments)
    except NodalError as error:
        print(f"nodal: error: {error}", file=sys.stderr)
        return ERROR
    except ModuleNotFoundError as error:
        if str(error.name).partition(".")[0] not in BENCH_MODULES:
            raise
        print(
            f"nodal: error: there is no {error.name} here: nodal {words[0]} needs the bench extra: pip install 'nodal[bench]'",
            file=sys.stderr,
        )
        return ERROR
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # whoever read our output has gone; keep the interpreter from complaining about that while it exits
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return ERROR
    return status


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="nodal",
        description="Closed-loop bench for tendon-driven continuum robots.",
        epilog="`nodal COMMAND --help` says more. Every error is one line, with exit status 2; a refusal exits with 3.",
    )
    parser.add_argument("--version", action=_Version, help="say which version this is")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, summary in COMMANDS.items():
        command = commands.add_parser(name, help=summary, description=summary[0].upper() + summary[1:] + ".")
        if name == next(iter(words), None):
            module = importlib.import_module(f"nodal.commands.{name}")
            module.add_arguments(command)
            command.set_defaults(run=module.run)
    return parser


class _Version(argparse.Action):
    def __init__(self, option_strings: Sequence[str], dest: str, help: str | None = None) -> None:  # noqa: A002
        super().__init__(option_strings, dest, nargs=0, help=help)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version  # noqa: PLC0415  slow to import, and rarely wanted

        print(f"nodal {version('nodal')}")
        parser.exit()


if __name__ == "__main__":
    sys.exit(main())
