"""An export as one ZIP file."""

from __future__ import annotations

import zipfile
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.workflows.export.export import Request, export_robot

_EPOCH = (2020, 1, 1, 0, 0, 0)
"""Date of all files of an archive, so that the same export gives the same bytes."""


def export_archive(
    design: TrunkDesign,
    request: Request | None = None,
    *,
    folder: str | Path | None = None,
    progress: Progress = ignore_progress,
) -> bytes:
    """Content of a ZIP file with all that `export_robot` writes.

    Args:
        design: the robot.
        request: what to make; everything by default.
        folder: an empty folder for the files, which stay there; a temporary one by default.
        progress: called as the work goes on.

    Raises:
        As `export_robot`.
    """
    if folder is None:
        with TemporaryDirectory(prefix="spiraltrunk-") as made:
            return export_archive(design, request, folder=made, progress=progress)
    root = Path(folder)
    result = export_robot(design, root, request, progress=progress)
    progress("archive", 0, 1)
    return _pack(root, result["files"])


def _pack(root: Path, names: list[str]) -> bytes:
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
        for name in sorted(names):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, (root / name).read_bytes())
    return content.getvalue()
