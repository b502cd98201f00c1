"""Jobs of the tab, each run in a process of its own."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from spiraltrunk.design import TrunkDesign
from spiraltrunk.studio.design.make_options import PAGE_OPTIONS
from spiraltrunk.workflows.export.archive import export_archive
from spiraltrunk.workflows.export.export import FORMATS, MOST_WORKERS, Request

ALL = "all formats"
"""Choice of all formats, with the models of the whole robot."""


def make_archive(report: Callable[[Any], None], design: TrunkDesign, parts: str, kind: str, folder: str) -> bytes:
    """Parts of a design as the content of a ZIP file.

    Args:
        report: gets what was made, how many of it, and of how many.
        design: the robot.
        parts: a group of parts, or "all".
        kind: a format of parts, or `ALL`.
        folder: an empty folder to work in.
    """
    formats = FORMATS if kind == ALL else (kind,)
    workers = min(MOST_WORKERS, len(os.sched_getaffinity(0)))
    request = Request(parts=(parts,), formats=formats, options=PAGE_OPTIONS, workers=workers)
    return export_archive(design, request, folder=folder, progress=lambda *step: report(step))
