"""The example of docs/virtual-bench.md runs as it stands there."""

import re
from pathlib import Path

DOCS = Path(__file__).parents[3] / "docs" / "virtual-bench.md"


def test_the_documented_example_runs(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    exec(compile(example, str(DOCS), "exec"), {})
    assert "{'tracking'}" in capsys.readouterr().out
