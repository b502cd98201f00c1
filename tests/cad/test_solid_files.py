"""A STEP or 3MF file that cannot be written is an error of the system, and never ends the process."""

from __future__ import annotations

import pytest

pytest.importorskip("build123d", reason="solids need the extra cad")

from spiraltrunk.cad.geometry.csg import rod
from spiraltrunk.cad.geometry.occ import build_mesh, build_solid, write_3mf, write_step


@pytest.mark.parametrize("place", ["missing/rod", "x" * 300])
def test_a_file_that_cannot_be_written_is_an_error_of_the_system(place, tmp_path):
    solid = build_solid(rod(1.0, (0, 0, 0), (0, 0, 5.0)))
    with pytest.raises(OSError, match=r"No such file|File name too long") as caught:
        write_step(solid, tmp_path / f"{place}.step", "rod")
    assert str(caught.value.filename) == str(tmp_path / f"{place}.step")
    with pytest.raises(OSError, match=r"No such file|File name too long"):
        write_3mf(build_mesh(solid, 0.1), tmp_path / f"{place}.3mf", "rod")
    assert list(tmp_path.iterdir()) == []


def test_a_path_that_is_no_utf8_is_written_to(tmp_path):
    """The kernel's own writer raised a TypeError."""
    solid, folder = build_solid(rod(1.0, (0, 0, 0), (0, 0, 5.0))), tmp_path / "a\udcff b"
    folder.mkdir()
    write_step(solid, folder / "rod.step", "rod")
    write_step(solid, tmp_path / "rod.step", "rod")
    assert (folder / "rod.step").read_bytes() == (tmp_path / "rod.step").read_bytes()
