"""The generated protobuf code is what the .proto file gives."""

import subprocess
import sys
from pathlib import Path

import pytest

import messaging

MESSAGING = Path(messaging.__file__).parent


@pytest.mark.parametrize("name", ["nodal_pb2.py", "nodal_pb2.pyi"])
def test_generated_code_is_not_stale(tmp_path, name):
    subprocess.run(
        [
            *(sys.executable, "-m", "grpc_tools.protoc", f"-I{MESSAGING / 'proto'}"),
            *(f"--python_out={tmp_path}", f"--pyi_out={tmp_path}", "nodal.proto"),
        ],
        check=True,
    )
    fresh, kept = (tmp_path / name).read_text(), (MESSAGING / "generated" / name).read_text()
    assert kept == fresh, (
        f"messaging/generated/{name} is older than messaging/proto/nodal.proto: run protoc again"
    )
