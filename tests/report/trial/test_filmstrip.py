"""A film strip shows each frame as it is, in reading order, over its caption."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from spiraltrunk.errors import ShapeError
from spiraltrunk.report import write_filmstrip
from spiraltrunk.report.trial.filmstrip import build_filmstrip, load_font, wrap_caption

COLORS = ((200, 30, 40), (20, 160, 60), (30, 60, 210), (240, 200, 20), (10, 10, 10))


def build_frames(n: int, height: int = 60, width: int = 90) -> list[np.ndarray]:
    return [np.full((height, width, 3), COLORS[i], dtype=np.uint8) for i in range(n)]


def test_frames_stand_in_reading_order(tmp_path: Path) -> None:
    path = write_filmstrip(tmp_path / "strip.png", build_frames(5), ["a", "b", "c", "d", "e"], columns=2)
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"))
    places = []
    for color in COLORS:
        rows, columns = np.nonzero((pixels == color).all(axis=2))
        assert rows.size >= 60 * 90
        places.append((int(np.median(rows)), int(np.median(columns))))
    y, x = np.array(places).T
    assert y[0] == y[1] < y[2] == y[3] < y[4]
    assert x[0] == x[2] == x[4] < x[1] == x[3]
    assert (pixels[[0, -1]] == 255).all()
    assert (pixels[:, [0, -1]] == 255).all()


def test_caption_is_written_under_its_frame() -> None:
    with_text = np.asarray(build_filmstrip(build_frames(2), ["reach", "grasp"]))
    without = np.asarray(build_filmstrip(build_frames(2), ["reach", ""]))
    changed = np.nonzero((with_text != without).any(axis=2))
    assert changed[0].min() >= 60  # Below the frames,
    assert changed[1].min() > with_text.shape[1] / 2  # on the right.


def test_long_caption_stays_within_its_frame() -> None:
    captions = ["a caption that is much too long for its narrow frame", "x" * 80, ""]
    font = load_font(10)
    for caption in captions:
        lines = wrap_caption(caption, font, 90).splitlines()
        assert all(font.getlength(line) <= 90 for line in lines)
        assert "".join(lines).replace(" ", "") == caption.replace(" ", "")
    one, more = (build_filmstrip(build_frames(1), [caption]) for caption in ("short", captions[0]))
    assert more.height > one.height
    assert more.width == one.width


def test_title_stands_over_the_frames() -> None:
    plain, titled = (build_filmstrip(build_frames(3), ["a", "b", "c"], title=title) for title in ("", "Wrap, 30 mm"))
    extra = titled.height - plain.height
    assert extra > 0
    np.testing.assert_array_equal(np.asarray(titled)[extra + 10 :], np.asarray(plain)[10:])


@pytest.mark.parametrize("sign", "\u00e9\u00d7\u2192\u00b5\u00b0")
def test_sign_beyond_ascii_is_drawn(sign: str) -> None:
    missing, drawn = (load_font(40).getmask(text) for text in ("\ue123", sign))
    assert bytes(drawn) != bytes(missing)


@pytest.mark.parametrize(("count", "captions"), [(3, ["a", "b"]), (0, [])])
def test_misfit_leaves_no_file(tmp_path: Path, count: int, captions: list[str]) -> None:
    with pytest.raises(ShapeError, match=f"{len(captions)} captions for {count} frames"):
        write_filmstrip(tmp_path / "strip.png", build_frames(count), captions)
    assert list(tmp_path.iterdir()) == []
