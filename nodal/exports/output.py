"""New files and folders: they have their name only once they are whole, and nothing that exists is overwritten."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from nodal.errors import CommandError, ExportError


@contextmanager
def new_file(path: Path) -> Iterator[Path]:
    """Where to write a file that gets this name when the block ends; raises CommandError, ExportError."""
    with _beside(path, Path.unlink) as draft:
        yield draft


@contextmanager
def new_folder(path: Path) -> Iterator[Path]:
    """An empty folder that gets this name when the block ends; raises CommandError, ExportError."""
    with _beside(path, shutil.rmtree) as draft:
        draft.mkdir()
        yield draft


def draft_of(path: Path) -> Path:
    """Where what gets this name is written until it is whole; raises CommandError when something stands there."""
    if path.exists():
        raise CommandError(f"{path} exists; nothing is overwritten, so name another or remove it")
    if not path.parent.is_dir():
        raise CommandError(f"{path}: there is no folder {path.parent}")
    draft = path.with_name(path.name + ".part")
    if draft.exists():
        raise CommandError(f"{draft} exists: another export is writing it, or one was killed; remove it then")
    return draft


@contextmanager
def _beside(path: Path, remove: Callable[[Path], None]) -> Iterator[Path]:
    draft = draft_of(path)
    try:
        yield draft
        draft.rename(path)
    except OSError as error:
        raise ExportError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        if draft.exists():
            remove(draft)
