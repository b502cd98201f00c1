"""Log of a run: in the output folder from its first message on, so that it stays however the run ends."""

from __future__ import annotations

import itertools
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from spiraltrunk.cli.output import DONE, complain

if TYPE_CHECKING:
    from spiraltrunk.files.output_folder import OutputFolder

LOG = "drive.mcap"
"""Name of the log of a run that came to its result."""


@contextmanager
def open_run_log(output: OutputFolder) -> Iterator[Path]:
    """Path of a new log in the folder, `unfinished-1.mcap` or the first number that is free; removed at the end.

    Where the block raises, or the program is killed, the log stays, and no later run replaces it. The block adds it to
    its draft by `add_log`.
    """
    names = (f"unfinished-{number}" for number in itertools.count(1))
    path = output.path / f"{next(name for name in names if not any(output.path.glob(f'{name}[.-]*')))}.mcap"
    try:
        yield path
    except BaseException:
        if path.exists():
            complain(f"the log of the run, up to where it ended, is {str(path)!r}", DONE)
        raise
    for part in _list_parts(path):
        part.unlink()


def add_log(path: Path, draft: Path) -> None:
    """Add a log that is closed to the draft, with all its parts, under the name `LOG`; it stays where it is, too."""
    from spiraltrunk.hardware.log.part import name_part

    for number, part in enumerate(_list_parts(path), start=1):
        place = name_part(draft / LOG, number)
        try:
            os.link(part, place)
        except OSError:  # No hard links here, as on FAT.
            shutil.copyfile(part, place)


def _list_parts(path: Path) -> list[Path]:
    """Files of a log, in order."""
    from spiraltrunk.hardware.log.part import name_part

    parts = (name_part(path, number) for number in itertools.count(1))
    return list(itertools.takewhile(Path.exists, parts))
