"""The files by which a plugged-in camera is found, as the kernel and udev make them."""

import itertools
from pathlib import Path

from drivers.simulated.v4l2.description import CameraDescription


class DeviceFiles:
    """`videoN` for pictures, `videoN+1` for metadata, and the names in `v4l/` that stay the same."""

    def __init__(self, folder: Path, description: CameraDescription) -> None:
        self._folder = folder
        self._beginnings = [folder / "v4l" / link for link in description.links]
        self._links: list[Path] = []
        self.nodes: tuple[Path, ...] = ()

    @property
    def lasting(self) -> Path:
        """The name by the port that the camera is plugged into."""
        return _link(self._beginnings[0], 0)

    def create(self) -> None:
        """The lowest numbers that are free are taken."""
        free = (
            path for number in itertools.count() if not (path := self._folder / f"video{number}").exists()
        )
        self.nodes = tuple(itertools.islice(free, 2))
        for index, node in enumerate(self.nodes):
            node.touch()
            for beginning in self._beginnings:
                link = _link(beginning, index)
                link.parent.mkdir(parents=True, exist_ok=True)
                link.symlink_to(Path("../..") / node.name)
                self._links.append(link)

    def remove(self) -> None:
        """Nothing is left."""
        for path in (*self._links, *self.nodes):
            path.unlink(missing_ok=True)
        self._links.clear()
        self.nodes = ()


def _link(beginning: Path, index: int) -> Path:
    return beginning.with_name(f"{beginning.name}-video-index{index}")
