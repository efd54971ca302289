"""The command line: help is quick, errors are one line, and nothing ends with a trace-back."""

import subprocess
import sys

import pytest

from nodal.__main__ import COMMANDS, main

SLOW = ("numpy", "cv2", "zenoh", "scipy", "matplotlib", "msgspec", "rich", "google.protobuf", "mcap")


def nodal(*words, **options):
    return subprocess.run(
        [sys.executable, "-m", "nodal", *words],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        **options,
    )


@pytest.mark.parametrize(
    "words", [[], *([name] for name in COMMANDS)], ids=lambda words: " ".join(words) or "nodal"
)
def test_help_imports_nothing_slow(words):
    program = (
        "import sys\n"
        "from nodal.__main__ import main\n"
        "try:\n"
        f"    main({[*words, '--help']!r})\n"
        "except SystemExit as end:\n"
        "    assert end.code == 0\n"
        f"print([name for name in {SLOW!r} if name in sys.modules], file=sys.stderr)\n"
    )
    shown = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert shown.stderr.strip() == "[]"
    assert shown.stdout.startswith("usage: nodal")


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "the following arguments are required: COMMAND"),
        (["fly"], "invalid choice: 'fly'"),
        (["do"], "the following arguments are required: action, --config"),
        (["do", "jump", "--config", "simulated"], "invalid choice: 'jump'"),
        (["sense"], "the following arguments are required: --config"),
        (["target", "--config", "simulated"], "required: KIND"),
        (["target", "--config", "simulated", "point", "tip=1,2"], "'1,2' is not 3 numbers"),
        (["target", "--config", "simulated", "point", "tip"], "'tip' is not NAME=X,Y,Z"),
        (["target", "--config", "simulated", "point", "tip=a,b,c"], "'a,b,c' is not 3 numbers"),
        (["nodes", "--config", "simulated", "tip"], "'tip' is not NAME=MM"),
        (["demo", "--duration", "long"], "invalid float value: 'long'"),
    ],
)
def test_words_that_do_not_fit_are_refused(capsys, words, complaint):
    with pytest.raises(SystemExit) as end:
        main(words)

    assert end.value.code == 2
    assert complaint in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (
            ["do", "status", "--config", "nowhere"],
            "nowhere: neither a bench file nor a bench that comes with nodal",
        ),
        (["sense", "--config", "nowhere.toml"], "nowhere.toml: no such file"),
        (["demo", "--duration", "1"], "--duration 1 s; allowed are 8 to 86400 s"),
        (["demo", "--duration", "nan"], "--duration nan s; allowed are"),
        (["nodes", "--config", "simulated", "tip=80", "middle=40"], "must increase"),
        (["nodes", "--config", "simulated", "tip=nan"], "not finite"),
        (["target", "--config", "simulated", "circle", "tip", "--radius", "nan"], "not finite"),
        (
            ["target", "--config", "simulated", "circle", "tip", "--period", "0"],
            "period is 0 s; it must be above 0",
        ),
        (["target", "--config", "simulated", "point", "tip=1,inf,3"], "not finite"),
        (["target", "--config", "simulated", "point", "tip=1,2,3", "--weight", "tip=0"], "weights"),
        (["target", "--config", "simulated", "file", "nowhere.csv"], "nowhere.csv: cannot be read"),
        (
            ["do", "status", "--config", "simulated", "--timeout", "0.3"],
            "nobody answered controller/do within 0.3 s",
        ),
    ],
)
def test_an_error_is_one_line_and_status_2(words, complaint, tmp_path):
    ended = nodal(*words, cwd=tmp_path)

    assert ended.returncode == 2
    assert ended.stdout == ""
    assert ended.stderr.startswith("nodal: error: ")
    assert complaint in ended.stderr
    assert ended.stderr.count("\n") == 1


def test_the_version_is_said():
    assert nodal("--version").stdout.startswith("nodal 0.")
