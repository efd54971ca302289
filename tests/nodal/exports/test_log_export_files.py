"""Pictures and attached files come out as they went in; nothing is overwritten, and every mistake is one clear line."""

import pytest


@pytest.fixture
def refused(nodal, recording, tmp_path):
    def refuse(*words):
        answer = nodal("log", "export", recording, "-o", tmp_path / "out", *words)
        assert answer.status == 2
        assert answer.out == []
        assert not list(tmp_path.glob("out*"))
        return answer.err[-1]

    return refuse


def test_attached_files_come_out_as_they_went_in(nodal, recording, tmp_path):
    assert nodal("log", "export", recording, "--to", "files", "-o", tmp_path / "out").status == 0
    assert (tmp_path / "out" / "bench.toml").read_bytes() == b"name = 'lean'\n"
    assert (tmp_path / "out" / "calibration.json").stat().st_size > 100


def test_pictures_come_out_as_they_went_in(nodal, recording, made, tmp_path):
    answer = nodal("log", "export", recording, "--to", "jpeg", "-o", tmp_path / "out", "--camera", "right")
    assert answer.status == 0
    (folder,) = (tmp_path / "out").iterdir()
    assert folder.name == "right"
    assert sorted(path.stem for path in folder.iterdir()) == [
        str(made.capture_ns(n)) for n in range(made.sets)
    ]
    (jpeg,) = {path.read_bytes() for path in folder.iterdir()}
    assert jpeg == made.picture_of(made.rig[1])


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (("--to", "csv", "--topics", "shapes"), ["--topics shapes", "shape, target"]),
        (("--to", "csv", "--topics", "shape/centreline"), ["shape/centreline", "drawn by viewers"]),
        (("--to", "csv", "--topics", "simulated/camera/*"), ["not recorded"]),
        (("--to", "csv", "--topics", "sensing/memory"), ["nothing was recorded", "sensing/memory"]),
        (("--to", "csv", "--from", "100"), ["nothing was recorded"]),
        (("--to", "csv", "--from", "1", "--until", "1"), ["--until 1", "--from 1"]),
        (("--to", "csv", "--from", "-1"), ["-1"]),
        (("--to", "csv", "--from", "noon"), ["noon", "seconds from the beginning"]),
        (("--to", "csv", "--width", "640"), ["--width", "--to csv"]),
        (("--to", "files", "--from", "1"), ["--from", "--to files"]),
        (("--to", "mp4", "--topics", "shape"), ["--topics", "--to mp4"]),
        (("--to", "mp4", "--width", "10"), ["--width 10", "320"]),
        (("--to", "mp4", "--camera", "top"), ["--camera top", "left, right"]),
        (("--to", "jpeg", "--camera", "top"), ["no pictures", "camera/top"]),
        (("--to", "xml"), ["xml", "csv"]),
    ],
)
def test_a_wrong_argument_is_refused_in_one_line_and_leaves_nothing(refused, words, parts):
    line = refused(*words)
    for part in parts:
        assert part in line


@pytest.mark.parametrize("kind", ["csv", "npz", "parquet", "mp4", "jpeg", "files"])
def test_nothing_is_overwritten(nodal, recording, tmp_path, kind):
    (tmp_path / "out").write_text("precious")
    answer = nodal("log", "export", recording, "--to", kind, "-o", tmp_path / "out")
    assert answer.status == 2
    assert "nothing is overwritten" in answer.err[-1]
    assert (tmp_path / "out").read_text() == "precious"


def test_a_folder_that_is_missing_is_named(nodal, recording, tmp_path):
    answer = nodal("log", "export", recording, "--to", "npz", "-o", tmp_path / "none" / "out.npz")
    assert answer.status == 2
    assert str(tmp_path / "none") in answer.err[-1]


def test_a_recording_that_is_missing_is_named(nodal, tmp_path):
    answer = nodal("log", "export", tmp_path / "no.mcap", "--to", "csv", "-o", tmp_path / "out")
    assert answer.status == 2
    assert "no.mcap" in answer.err[-1]
