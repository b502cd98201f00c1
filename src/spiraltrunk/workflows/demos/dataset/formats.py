"""Formats of data sets: how each is written, which files it always has, and the packages that it needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Final, final

from spiraltrunk.errors import UnknownName
from spiraltrunk.workflows.demos.dataset import minari_format
from spiraltrunk.workflows.demos.dataset.layout import Episodes, Layout
from spiraltrunk.workflows.demos.dataset.lerobot import features
from spiraltrunk.workflows.demos.dataset.lerobot.write import write_lerobot
from spiraltrunk.workflows.demos.dataset.robomimic import FILE, write_robomimic


@final
@dataclass(frozen=True, kw_only=True)
class Format:
    """A format of data sets."""

    name: str
    """Its name."""
    write: Callable[[Episodes, Layout, Path], None]
    """Writes episodes, one or more, into an empty folder."""
    files: tuple[str, ...]
    """Files that every data set has, as paths below the folder."""
    packages: tuple[str, ...]
    """Packages that it is written with."""

    def check_packages(self) -> None:
        """Import the packages.

        Raises:
            ModuleNotFoundError: for the first that is missing.
        """
        for name in self.packages:
            import_module(name)


_FIRST = {"chunk_index": 0, "file_index": 0}

FORMATS: Final = {
    each.name: each
    for each in (
        Format(
            name="lerobot", write=write_lerobot, packages=("pyarrow",),
            files=(
                features.DATA_PATH.format(**_FIRST), features.EPISODES_PATH.format(**_FIRST), "meta/info.json",
                "meta/spiraltrunk.json", "meta/stats.json", "meta/tasks.parquet",
            ),
        ),
        Format(name="robomimic", write=write_robomimic, packages=("h5py",), files=(FILE,)),
        Format(name="minari", write=minari_format.write_minari, packages=("h5py", "minari"), files=minari_format.FILES),
    )
}  # fmt: skip
"""Formats by their names."""


def get_format(name: str) -> Format:
    """The format of a name.

    Raises:
        UnknownName: lists the names.
    """
    if name not in FORMATS:
        raise UnknownName("format", name, FORMATS)
    return FORMATS[name]
