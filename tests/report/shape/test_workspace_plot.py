"""The picture of the workspace."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from spiraltrunk.design import presets
from spiraltrunk.model.inverse import workspace
from spiraltrunk.report.shape.workspace_plot import build_workspace_figure
from spiraltrunk.report.style import write_figure


def test_picture_has_both_views_in_millimetres(tmp_path: Path) -> None:
    found = workspace.map(presets.PAPER, levels=5)
    path = write_figure(build_workspace_figure(found, title="Tips"), tmp_path / "workspace.png")
    with Image.open(path) as picture:
        assert picture.width > 800
    space, plane, bar = build_workspace_figure(found).axes
    assert space.get_xlabel() == "x [mm]"
    assert plane.get_ylabel() == "y, up [mm]"
    assert "[N]" in bar.get_ylabel()
    drawn = plane.collections[0].get_offsets()
    assert len(drawn) == found.in_plane(0.01).sum()
    assert np.abs(drawn).max() <= 1e3 * found.length + 1e-6


def test_tips_on_a_line_have_no_hull() -> None:
    found = workspace.map(presets.get("spirob-15"), levels=2)
    assert build_workspace_figure(found).axes
