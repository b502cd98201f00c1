"""Film strip: a sheet of frames with a caption under each."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from spiraltrunk.errors import ShapeError
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.report.style import INK, LIMIT

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFont import FreeTypeFont

_LETTER_SHARE = 1 / 18
"""Letter height of a caption over the width of a frame: legible on a page as wide as four frames."""


def write_filmstrip(
    path: str | Path,
    frames: Sequence[np.ndarray],
    captions: Sequence[str],
    columns: int = 4,
    *,
    title: str = "",
    marked: Collection[int] = (),
) -> Path:
    """Write a white sheet of frames in reading order, each over its caption; the path's ending sets the format.

    Args:
        path: file to write.
        frames: pictures of one size, shape (height, width, 3), 0 to 255.
        captions: one for each frame; long ones are wrapped.
        columns: largest number of frames in a row.
        title: title of the sheet.
        marked: numbers of the frames, from 0, that get a border and a caption in the colour of limits.

    Raises:
        ShapeError: where the number of captions is not that of the frames.
        OSError: where the file cannot be written.
    """
    sheet = build_filmstrip(frames, captions, columns, title=title, marked=marked)
    with atomic_file(path) as draft:
        sheet.save(draft)
    return Path(path)


def build_filmstrip(
    frames: Sequence[np.ndarray],
    captions: Sequence[str],
    columns: int = 4,
    *,
    title: str = "",
    marked: Collection[int] = (),
) -> Image:
    """Build the sheet that `write_filmstrip` writes."""
    from PIL import Image, ImageDraw

    if not frames or len(captions) != len(frames):
        raise ShapeError(f"{len(captions)} captions for {len(frames)} frames; allowed: one for each, and one or more")
    height, width = frames[0].shape[:2]
    columns = min(columns, len(frames))
    margin = max(10, round(width * _LETTER_SHARE))
    font, head = load_font(margin), load_font(round(1.25 * margin))
    texts = [wrap_caption(caption, font, width) for caption in captions]
    title = wrap_caption(title, head, columns * (width + margin) - margin)
    tall = _height(max(texts, key=lambda text: text.count("\n")), font)
    top = margin + (_height(title, head) + margin if title else 0)
    pitch = height + margin // 3 + tall + margin
    rows = -(-len(frames) // columns)
    sheet = Image.new("RGB", (margin + columns * (width + margin), top + rows * pitch), "white")
    draw = ImageDraw.Draw(sheet)
    draw.multiline_text((margin, margin), title, font=head, fill=INK)
    for i, (frame, text) in enumerate(zip(frames, texts, strict=True)):
        left, upper = margin + i % columns * (width + margin), top + i // columns * pitch
        sheet.paste(Image.fromarray(np.ascontiguousarray(frame)), (left, upper))
        place = (left + width / 2, upper + height + margin // 3)
        draw.multiline_text(place, text, font=font, fill=LIMIT if i in marked else INK, anchor="ma", align="center")
        if i in marked:
            border = max(3, margin // 4)
            box = (left - border, upper - border, left + width + border - 1, upper + height + border - 1)
            draw.rectangle(box, outline=LIMIT, width=border)
    return sheet


def _height(text: str, font: FreeTypeFont) -> int:
    """Height of a text of as many lines, whatever its letters [pixels]."""
    from PIL import Image, ImageDraw

    lines = "\n".join("Ag" for _ in text.split("\n"))
    return round(ImageDraw.Draw(Image.new("RGB", (1, 1))).multiline_textbbox((0, 0), lines, font=font)[3])


def load_font(size: int) -> FreeTypeFont:
    """DejaVu Sans as matplotlib ships it: it has arrows and accents, and does not depend on the machine."""
    import matplotlib
    from PIL import ImageFont

    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", size=size)


def wrap_caption(caption: str, font: FreeTypeFont, width: float) -> str:
    """The caption in lines that fit a width [pixels], by the font's mean letter width; units stay with numbers."""
    caption = re.sub(r"(?<=\d) (?=(?:s|m/s|mm|cm|deg)\b)", "\N{NO-BREAK SPACE}", caption)
    return fill(caption, max(1, int(width / font.getlength("n"))))
