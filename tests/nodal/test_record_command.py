"""`nodal record` as an operator meets it."""

import contextlib
import subprocess
import sys

import msgspec
import pytest

from messaging.session import open_rendezvous
from nodal.__main__ import main
from nodal.bench_file import load_bench
from nodal.toml_file import written
from recordings.source import finished


@pytest.fixture
def recorder(tmp_path, zenoh_settings):
    """A bench whose recorder runs in a process of its own; its bench file."""
    settings = load_bench("simulated").settings
    settings = msgspec.structs.replace(
        settings,
        zenoh=zenoh_settings,
        recorder=msgspec.structs.replace(
            settings.recorder, folder=str(tmp_path / "kept"), begin="on request"
        ),
    )
    config = tmp_path / "bench.toml"
    config.write_text(written(msgspec.to_builtins(settings)))
    command = [sys.executable, "-m", "nodal", "record", "--config", str(config)]
    with contextlib.ExitStack() as stack:
        stack.enter_context(open_rendezvous(zenoh_settings, settings.name))
        process = subprocess.Popen(command)
        stack.callback(process.wait, 30)
        stack.callback(process.terminate)
        yield config


def test_a_running_recorder_is_asked(recorder, tmp_path, capsys):
    def ask(*words):
        status = main(["record", *words, "--config", str(recorder), "--timeout", "20"])
        said = capsys.readouterr()
        return status, said.out + said.err

    status, said = ask("status")
    assert status == 0
    assert said.startswith("waiting: nothing was asked for yet; ")
    assert ask("stop") == (3, "nodal: refused: nothing is being recorded (state: waiting)\n")
    status, said = ask("start", "--file", "circle.mcap")
    assert status == 0
    assert said.startswith(f"recording: {tmp_path}/kept/circle.mcap: ")
    assert ask("save")[0] == 3
    status, said = ask("stop")
    assert status == 0
    assert f"{tmp_path}/kept/circle.mcap ended (" in said
    assert finished(tmp_path / "kept" / "circle.mcap")


def test_actions_are_named(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["record", "rewind", "--config", "simulated"])
    assert ended.value.code == 2
    assert "'start', 'stop', 'save', 'status'" in capsys.readouterr().err
