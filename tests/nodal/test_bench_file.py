"""Bench files: what is refused, and in which words."""

import re
import tomllib
from pathlib import Path

import msgspec
import pytest

from controller.settings import ControllerSettings
from messaging.settings import RobotSettings
from nodal.bench_file import bench_path, load_bench
from nodal.errors import BenchFileError, CalibrationFileError
from nodal.settings_reference import with_reference
from nodal.toml_file import written

SIMULATED = bench_path("simulated")
DOCUMENT = Path(__file__).parents[2] / "docs" / "bench-file.md"


@pytest.fixture
def table():
    table = tomllib.loads(SIMULATED.read_text(encoding="utf-8"))
    table["calibration"] = str(SIMULATED.with_name(table["calibration"]))
    return table


def loaded(tmp_path, table):
    file = tmp_path / "bench.toml"
    file.write_text(written(table), encoding="utf-8")
    return load_bench(file)


def refused(tmp_path, table):
    with pytest.raises((BenchFileError, CalibrationFileError)) as raised:
        loaded(tmp_path, table)
    return str(raised.value)


def identified_before_pulleys_were_changed():
    controller = ControllerSettings()
    drawing = controller.drawing(RobotSettings(section_length_mm=(40.0, 40.0)), (5.0, -5.0, 5.0, 5.0, 2.0))
    return {
        "date": "then",
        "drawing": msgspec.to_builtins(drawing),
        "gain": [[0.0] * 4] * 4,
        "gain_sigma": [[0.1] * 4] * 4,
        "bias_rad": [0.0] * 4,
        "bias_sigma_rad": [0.1] * 4,
        "lost_motion_mm": [0.3] * 4,
        "lost_motion_sigma_mm": [0.1] * 4,
        "stage_gain": [0.0],
        "stage_gain_sigma": [0.1],
    }


def test_the_simulated_bench_is_called_by_its_name():
    bench = load_bench("simulated")

    assert bench.settings.name == "simulated"
    assert [camera.camera for camera in bench.rig] == ["left", "right"]


def test_what_the_shipped_bench_makes_goes_below_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    settings = load_bench("simulated").settings

    assert settings.servos.port == str(tmp_path / "runs" / "simulated" / "servos")
    assert settings.servos.port == settings.simulation.servos.link


def test_relative_paths_begin_at_the_bench_file(tmp_path, table):
    table["recorder"]["folder"] = "recordings"

    assert loaded(tmp_path, table).settings.recorder.folder == str(tmp_path / "recordings")


def test_a_law_file_begins_at_the_bench_file_and_none_stays_none(tmp_path, table):
    table["controller"] = {"law_file": "my_law.py"}
    mine = loaded(tmp_path, table)
    table["controller"]["law_file"] = ""

    assert mine.settings.controller.law_file == str(tmp_path / "my_law.py")
    assert loaded(tmp_path, table).settings.controller.law_file == ""


def test_absolute_paths_stay(tmp_path, table):
    table["servos"]["port"] = "/dev/ttyUSB0"

    assert loaded(tmp_path, table).settings.servos.port == "/dev/ttyUSB0"


def test_the_effective_bench_file_says_the_same(tmp_path, table):
    bench = loaded(tmp_path, table)
    again = tmp_path / "again.toml"
    again.write_text(bench.text(), encoding="utf-8")

    assert load_bench(again).settings == bench.settings


def test_attachments_hold_the_bench_and_the_calibration(tmp_path, table):
    bench = loaded(tmp_path, table)

    attached = bench.attachments()

    assert tomllib.loads(attached["bench.toml"].decode())["name"] == "simulated"
    assert attached["calibration.json"] == Path(table["calibration"]).read_bytes()


@pytest.mark.parametrize("key", ["name", "robot", "calibration", "cameras", "sensing", "servos"])
def test_a_missing_key_is_named(tmp_path, table, key):
    del table[key]

    assert f"bench.toml: {key} is missing; the file takes name, " in refused(tmp_path, table)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda table: table.update(speed=1), "speed is unknown; the file takes"),
        (lambda table: table.update(name="my bench"), "name = 'my bench': expected `str` matching"),
        (
            lambda table: table["sensing"].update(maximum_skew_s=0),
            "sensing.maximum_skew_s = 0: expected `float` > 0",
        ),
        (lambda table: table["robot"].update(tip="round"), "robot.tip is unknown; [robot] takes"),
        (
            lambda table: table["sensing"].update(maximum_skew_s="6"),
            "sensing.maximum_skew_s = '6': expected `float`, got `str`",
        ),
        (lambda table: table["cameras"].pop("left"), "cameras: expected `object` of length >= 2"),
        (
            lambda table: table["servos"]["stage"].update(id=300),
            "servos.stage.id = 300: expected `int` <= 252",
        ),
        (lambda table: table["servos"]["stage"].update(id=1), "servos: axes: every id must be used once"),
        (
            lambda table: table.update(controller={"rate_hz": 10}),
            "controller.rate_hz = 10: expected `float` >= 20.0",
        ),
        (
            lambda table: table.update(zenoh={"rendezvous": "7447"}),
            "zenoh.rendezvous = '7447': expected `str` matching",
        ),
        (
            lambda table: table["sensing"]["nodal_points"].append({"name": "beyond", "arc_mm": 81}),
            "beyond at 81 mm is beyond the robot, whose sections add up to 80 mm",
        ),
        (
            lambda table: table["sensing"]["nodal_points"].reverse(),
            "sensing.nodal_points: distances [80.0, 60.0, 40.0, 20.0] mm must increase",
        ),
        (
            lambda table: table["servos"]["tendons"].pop(),
            "servos.tendons has 3 servos; controller.sections needs 4",
        ),
        (
            lambda table: table.update(controller={"limits": {"displacement_mm": 7}}),
            "controller.limits.displacement_mm 7 reaches beyond servo proximal x, which travels -6 to 6 mm",
        ),
        (
            lambda table: table.update(controller={"identified": identified_before_pulleys_were_changed()}),
            "another drawing: mm_per_rad was [5.0,-5.0,5.0,5.0,2.0] and is [5.0,5.0,5.0,5.0,2.0]; take the table out",
        ),
        (
            lambda table: table["servos"]["stage"].update(max_current_ma=800),
            "servo stage bounds itself at max_current_ma 800, so controller.limits.current_ma 800 would never be exceeded",
        ),
        (
            lambda table: table["servos"]["stage"].pop("zero_ticks"),
            "servos.stage.zero_ticks is missing: without it the stage's travel would begin wherever it stands",
        ),
        (lambda table: table["servos"].pop("stage"), "robot.stage is true; servos.stage is missing"),
        (
            lambda table: table["robot"].update(stage=False),
            "robot.stage is false; servos.stage is given",
        ),
        (
            lambda table: table["robot"].update(section_length_mm=[80]),
            "controller.sections describes 2 sections; robot.section_length_mm has 1",
        ),
        (
            lambda table: table["robot"].update(section_length_mm=[50, 30]),
            "simulation.robot.sections are [40.0, 40.0] mm long; robot.section_length_mm says [50.0, 30.0]",
        ),
        (
            lambda table: table["cameras"].update(top=table["cameras"]["left"]),
            "cameras.top is not in the calibration",
        ),
        (
            lambda table: table["sensing"].update(background={"top": "top.jpg"}),
            "sensing.background.top is not one of the cameras left, right",
        ),
        (
            lambda table: table["sensing"].update(work_area={"top": [[0, 0], [9, 0], [9, 9]]}),
            "sensing.work_area.top is not one of the cameras left, right",
        ),
        (
            lambda table: table["sensing"].update(work_area={"left": [[0, 0], [1930, 0], [9, 900]]}),
            "sensing.work_area.left has a corner [1930, 0] outside of the picture, which is 1920x1080 px",
        ),
        (
            lambda table: table["sensing"].update(work_area={"right": [[0, 0], [99, 0], [99, 99]]}),
            "sensing.work_area.right does not contain the robot's base, which the camera sees at [",
        ),
        (
            lambda table: table["sensing"].update(background={"left": "nowhere.jpg"}),
            "nowhere.jpg: cannot be read: No such file",
        ),
        (
            lambda table: table.update(calibration="nowhere.json"),
            "nowhere.json: cannot be read: No such file",
        ),
    ],
)
def test_a_bad_bench_is_refused_in_words(tmp_path, table, change, complaint):
    change(table)

    assert complaint in refused(tmp_path, table)


def test_everything_that_does_not_fit_is_said_at_once(tmp_path, table):
    table["servos"]["tendons"].pop()
    table["cameras"]["top"] = table["cameras"]["left"]

    complaint = refused(tmp_path, table)

    assert "cameras.top" in complaint
    assert "servos.tendons" in complaint


@pytest.mark.parametrize("name", ["nowhere", "nowhere.toml", "some/folder/bench"])
def test_a_bench_that_is_not_there_is_named(name):
    with pytest.raises(BenchFileError, match=re.escape(name)):
        load_bench(name)


def test_the_documented_reference_is_in_step_with_the_settings():
    document = DOCUMENT.read_text(encoding="utf-8")

    assert document == with_reference(document), "make docs"


def test_the_folder_of_a_bench_file_means_that_file(tmp_path, table):
    loaded(tmp_path, table)

    assert bench_path(tmp_path) == tmp_path / "bench.toml"
