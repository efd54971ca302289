"""YAML files of ROS and of Kalibr."""

from pathlib import Path
from typing import Any

import yaml

from nodal.calibration.formats.calibration import text_of
from nodal.errors import CalibrationFileError


def mapping_in(file: Path) -> dict[str, Any]:
    """What is in the file; a first line `%YAML:1.0`, which OpenCV wants and YAML forbids, is passed over. Raises CalibrationFileError."""
    text = text_of(file)
    if text.startswith("%YAML"):
        text = text.partition("\n")[2]
    try:
        content = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise CalibrationFileError(f"{file}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise CalibrationFileError(f"{file}: not a calibration: it holds no keys")
    return content


def entry(source: str, content: Any, key: str) -> Any:
    """One of its values; raises CalibrationFileError when it is missing, or where there are no keys at all."""
    if not isinstance(content, dict):
        raise CalibrationFileError(f"{source}: {content!r} stands where {key} and other keys should")
    if key not in content:
        raise CalibrationFileError(f"{source}: {key} is missing; it holds {', '.join(map(str, content))}")
    return content[key]


def dumped(content: dict[str, Any]) -> str:
    """YAML text, with lists of numbers on one line."""
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=10**6)
