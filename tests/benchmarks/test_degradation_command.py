"""`python -m benchmarks.degradations` prints its table, writes it to files, and draws what it is asked to."""

import json

import cv2
import numpy as np
import pytest

from benchmarks.degradations.__main__ import main
from benchmarks.degradations.cases import CASES


def test_list_names_every_case_and_level(capsys):
    assert main(["--list"]) == 0

    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in lines] == [case.name for case in CASES]
    assert all(level.name in line for case, line in zip(CASES, lines, strict=True) for level in case.levels)


def test_the_table_of_one_case_is_printed_and_written(tmp_path, capsys):
    files = tmp_path / "table.json", tmp_path / "table.md"

    done = main(["--only", "none", "--poses", "1", "--json", str(files[0]), "--markdown", str(files[1])])

    assert done == 0
    method, head, *rows = capsys.readouterr().out.splitlines()[:4]
    assert method == "method refined"
    assert head.startswith("case")
    assert [line.split()[0] for line in rows] == ["none", "all"]
    [reference, total] = json.loads(files[0].read_text())
    assert reference["cold"]["estimates"] == 1
    assert reference["warm"]["estimates"] == 3
    assert reference["reasons"] == total["reasons"]
    assert files[1].read_text().startswith("| case | level |")


def test_one_pose_is_reproduced_and_drawn(tmp_path, capsys):
    assert main(["--reproduce", "none:reference:1", "--figures", str(tmp_path)]) == 0

    lines = capsys.readouterr().out.splitlines()
    starts = ["prior", "cold", "warm-0", "warm-1", "warm-2"]
    assert [line.split()[2] for line in lines] == [f"({start}):" for start in starts]
    assert {path.name for path in tmp_path.iterdir()} == {f"refined-{start}" for start in starts}
    drawn = cv2.imread(str(tmp_path / "refined-cold" / "left.png"))
    green = (drawn[..., 1] > 200) & (drawn[..., 0] < 100) & (drawn[..., 2] < 100)
    assert np.count_nonzero(green) > 1500
    assert (tmp_path / "refined-cold" / "rig.json").exists()


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--only", "rain"], "no case 'rain'"),
        (["--poses", "0"], "must be 1 or more"),
        (["--methods", "guess"], "refined, plain"),
        (["--reproduce", "none:reference"], "CASE:LEVEL:NUMBER"),
        (["--reproduce", "noise:5 levels:0"], "4 levels, 8 levels, 16 levels"),
    ],
)
def test_words_it_does_not_know_are_named(words, named, capsys):
    with pytest.raises(SystemExit):
        main(words)

    assert named in capsys.readouterr().err
