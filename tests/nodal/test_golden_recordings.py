"""The golden recordings replay to the same bits, in processes of their own, as a user would have it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from messaging import topics
from recordings.log import Log

DATA = Path(__file__).parents[1] / "data"
GOLDEN = sorted(DATA.glob("*.mcap"))
MADE = {"shape": topics.SHAPE, "tendon/command": topics.TENDON_COMMAND, "asked": topics.ASKED}


def test_there_are_golden_recordings_of_a_few_megabytes():
    assert [path.name for path in GOLDEN] == ["photographs.mcap", "run.mcap"]
    assert sum(path.stat().st_size for path in GOLDEN) < 8e6


@pytest.mark.parametrize("recording", GOLDEN, ids=lambda path: path.stem)
def test_a_golden_recording_replays_to_the_same_bits(recording):
    done = subprocess.run(
        [sys.executable, "-m", "nodal", "replay", str(recording), "--json"],
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert done.returncode == 0, f"{done.stdout}\n{done.stderr}\n`make golden` if another result is meant"
    (verdict,) = json.loads(done.stdout)["verdicts"]
    compared = verdict["comparison"]["topics"]
    for key, topic in MADE.items():
        in_log = [one for one in Log(recording).messages([topic]) if _concerns_replay(one)]
        assert compared.get(key, {"compared": 0})["compared"] == len(in_log)
    assert verdict["comparison"]["skipped"] == {}
    assert verdict["damage"] == []


def _concerns_replay(recorded):
    """What sensing and the recorder were asked is not run again."""
    return recorded.topic != topics.ASKED.key or recorded.message.service.startswith(
        ("controller/", topics.STOP.key)
    )
