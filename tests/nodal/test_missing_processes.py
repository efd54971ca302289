import socket

import pytest

from messaging.errors import UnansweredError
from nodal.bench_file import bench_path, read_bench
from nodal.errors import ProcessError
from nodal.processes import child as children
from nodal.processes.missing import with_processes
from nodal.toml_file import read_table, written


@pytest.fixture
def bench(tmp_path):
    table = read_table(bench_path("simulated"))
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        table["zenoh"] = {"rendezvous": f"tcp/127.0.0.1:{probe.getsockname()[1]}"}
    table["calibration"] = "not-yet.json"
    (tmp_path / "bench.toml").write_text(written(table), encoding="utf-8")
    return read_bench(tmp_path / "bench.toml")


def test_what_runs_already_is_not_started_twice(bench, eventually):
    with with_processes(bench, "first", ("rendezvous",)) as first:
        assert eventually(lambda: "rendezvous" in first.alive())
        # a second rendezvous would find its endpoint in use
        with with_processes(bench, "second", ("rendezvous",)) as second:
            assert eventually(lambda: {"first", "rendezvous"} <= second.alive())
        assert "rendezvous" in first.alive()


def test_what_was_started_ends_with_its_user(bench, eventually):
    with with_processes(bench, "first", ("rendezvous",)) as session:
        assert eventually(lambda: "rendezvous" in session.alive())
    with with_processes(bench, "second", ()) as session:
        assert "rendezvous" not in session.alive()


def test_a_process_that_keeps_dying_is_told_with_its_last_words(bench, monkeypatch, eventually):
    monkeypatch.setattr(children, "RESTARTS_ALLOWED", 0)
    # the bench is not calibrated, so sensing cannot start
    with (
        pytest.raises(ProcessError, match=r"(?s)sense ended .*not-yet\.json"),
        with_processes(bench, "first", ("rendezvous", "sense")),
    ):
        raise UnansweredError("sensing is not there")
