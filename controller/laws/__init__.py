"""The control laws, one file each. `law = "NAME"` in the bench file names a file of this folder; `law_file` any other file.

A law's file offers `Tuning`, the struct of its settings (`[controller.tuning]` in the bench file), and
`make(tuning, plant)`, which returns a `controller.law.Law`. Homing is led by `HOMING` whatever the law: it has to work
before anything is known of the robot.
"""

import importlib
import importlib.util
import pkgutil
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import msgspec

from controller.errors import ControllerSetupError
from controller.law import Law
from controller.plant import Plant
from controller.settings import ControllerSettings

HOMING = "resolved_rate"


def law_names() -> tuple[str, ...]:
    """The laws that come with the controller."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def make_law(settings: ControllerSettings, plant: Plant) -> Law[Any]:
    """The law that the settings name, with its tuning; raises ControllerSetupError."""
    module = _file(Path(settings.law_file)) if settings.law_file else _shipped(settings.law)
    return _made(module, settings.tuning, plant)


def make_homing_law(settings: ControllerSettings, plant: Plant) -> Law[Any]:
    """The law that leads the robot straight, tuned as the settings say if it is theirs; raises ControllerSetupError."""
    tuned = settings.law == HOMING and not settings.law_file
    return _made(_shipped(HOMING), settings.tuning if tuned else {}, plant)


def _made(module: ModuleType, settings: dict[str, Any], plant: Plant) -> Law[Any]:
    name = module.__name__.rpartition(".")[2]
    try:
        tuning = msgspec.convert(settings, module.Tuning)
    except msgspec.ValidationError as error:
        raise ControllerSetupError(f"controller.tuning of law {name}: {error}") from error
    try:
        law: Law[Any] = module.make(tuning, plant)
    except Exception as error:  # it may be a stranger's file
        raise ControllerSetupError(f"law {name} cannot be made: {type(error).__name__}: {error}") from error
    if missing := [part for part in ("start", "step", "lead_s") if not hasattr(law, part)]:
        raise ControllerSetupError(f"law {name} has no {' and no '.join(missing)}: see controller/law.py")
    return law


def _shipped(name: str) -> ModuleType:
    if name not in law_names():
        raise ControllerSetupError(f"law {name!r} is not known; known are {', '.join(law_names())}")
    return importlib.import_module(f"{__name__}.{name}")


def _file(path: Path) -> ModuleType:
    """A law's file from anywhere. It becomes a module of this package, so that what it remembers can be kept and replayed."""
    if path.stem in law_names():
        raise ControllerSetupError(
            f"controller.law_file = {path}: {path.stem} is the name of a law that comes with nodal"
        )
    name = f"{__name__}.{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise ControllerSetupError(f"controller.law_file = {path}: there is no such Python file")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever a stranger's file does wrong is said in its own words
        raise ControllerSetupError(
            f"controller.law_file = {path}: {type(error).__name__}: {error}"
        ) from error
    if missing := [wanted for wanted in ("Tuning", "make") if not hasattr(module, wanted)]:
        raise ControllerSetupError(f"controller.law_file = {path}: it offers no {' and no '.join(missing)}")
    return module
