"""Recordings of a page: files under names of our own in a temporary folder, and what the person calls them."""

from __future__ import annotations

import secrets
import shutil
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.protocol.protocol import Protocol, guess_run
from spiraltrunk.mocap.protocol.toml import PACKAGED, load_protocol
from spiraltrunk.studio.page.scratch import make_scratch

MOST_TAKES = 24
"""Recordings of a page [-]."""

_ENDINGS = (".csv", ".c3d", ".tak")
"""Endings that the readers of recordings know; `.tak` is refused by them with what to do."""


@final
@dataclass(frozen=True, kw_only=True)
class StoredTake:
    """One recording."""

    run: str
    """Run of the protocol that it belongs to."""
    file: str
    """Where it is kept."""
    name: str
    """Name that the person knows it by."""


@final
class TakeFolder:
    """Recordings and protocol of a page."""

    def __init__(self) -> None:
        self.name = secrets.token_hex(8)
        """Name by which a reload finds it."""
        self.protocol: Protocol = load_protocol(PACKAGED)
        """The session's protocol."""
        self.protocol_file = PACKAGED
        """Its name, or its file."""
        self.takes: list[StoredTake] = []
        """Recordings in the order in which they came."""
        self._count = 0
        self._folder: Path | None = None

    @property
    def folder(self) -> Path:
        """Temporary folder, made at its first use; nothing in it has a name that came from the page."""
        if self._folder is None:
            self._folder = make_scratch("measure")
        return self._folder

    def add(self, name: str, content: bytes, run: str | None) -> StoredTake:
        """Keep an uploaded recording.

        Args:
            name: name of the file at the person's, for texts; only its ending and its beginning are read.
            content: what is in it.
            run: the run that it belongs to; None where its name begins with the run's.

        Raises:
            TakeError: where it is no recording, belongs to no run, or there are too many.
        """
        ending = next((ending for ending in _ENDINGS if name.lower().endswith(ending)), None)
        if ending is None:
            raise TakeError(f"{name!r} is no recording; allowed: a Motive CSV, or C3D")
        if not content:
            raise TakeError(f"{name!r} is empty; allowed: a Motive CSV, or C3D, with data")
        if len(self.takes) >= MOST_TAKES:
            raise TakeError(f"there are {MOST_TAKES} takes already; allowed: {MOST_TAKES}; remove them first")
        runs = [one.name for one in self.protocol.runs]
        chosen = guess_run(self.protocol, name) if run is None else run
        if chosen not in runs:
            allowed = f"{', '.join(runs)}{self._format_way_back()}"
            raise TakeError(f"{name!r} begins with no run's name; choose its run: {allowed}")
        file = self.next_file(ending)
        file.write_bytes(content)
        take = StoredTake(run=chosen, file=str(file), name=name)
        self.takes.append(take)
        return take

    def _format_way_back(self) -> str:
        """How to come back to the packaged protocol, where another holds."""
        if self.protocol_file == PACKAGED:
            return ""
        return "; Session, Remove all takes brings back the runs of the packaged protocol"

    def remove(self, take: StoredTake) -> None:
        """Forget a recording."""
        self.takes.remove(take)
        Path(take.file).unlink(missing_ok=True)

    def clear(self) -> None:
        """Forget all recordings, and take the packaged protocol again."""
        for take in tuple(self.takes):
            self.remove(take)
        self.protocol, self.protocol_file = load_protocol(PACKAGED), PACKAGED

    def set_protocol(self, content: bytes, name: str) -> None:
        """Take an uploaded protocol; recordings of another are forgotten.

        Args:
            content: the file.
            name: what the person calls it.

        Raises:
            TakeError: where it is none.
        """
        file = self.next_file(".toml")
        file.write_bytes(content)
        try:
            protocol = load_protocol(file)
        except TakeError as error:
            file.unlink()
            raise TakeError(str(error).replace(str(file), name)) from None
        self.clear()
        self.protocol, self.protocol_file = protocol, str(file)

    def set_virtual(self, folder: Path, run: str, files: Sequence[str]) -> None:
        """Take a virtual session instead of what was there."""
        self.clear()
        self.protocol_file = str(folder / "protocol.toml")
        self.protocol = load_protocol(self.protocol_file)
        self.takes = [StoredTake(run=run, file=file, name=f"virtual take {i}") for i, file in enumerate(files, 1)]

    def next_file(self, ending: str) -> Path:
        """A new path in the folder."""
        self._count += 1
        return self.folder / f"upload_{self._count}{ending}"

    def list_by_run(self) -> dict[str, list[str]]:
        """Files by run, in the protocol's order."""
        found = {run.name: [take.file for take in self.takes if take.run == run.name] for run in self.protocol.runs}
        return {run: files for run, files in found.items() if files}

    def name_files(self, text: str) -> str:
        """A text in which paths are replaced by the names of the uploaded files."""
        for take in self.takes:
            text = text.replace(take.file, take.name)
        return text.replace(self.protocol_file, "the protocol") if self.protocol_file != PACKAGED else text

    def close(self) -> None:
        """Remove the folder."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)


_MOST_KEPT = 8
"""Folders of closed pages that are kept for a reload [-]."""

_kept: OrderedDict[str, TakeFolder] = OrderedDict()


def keep_folder(folder: TakeFolder) -> None:
    """Keep the folder of a page that closes, for its reload; of many the oldest is removed."""
    _kept[folder.name] = folder
    while len(_kept) > _MOST_KEPT:
        _kept.popitem(last=False)[1].close()


def find_folder(name: str) -> TakeFolder | None:
    """Take the folder that was kept for a reloaded page; None where it is no longer kept."""
    return _kept.pop(name, None)
