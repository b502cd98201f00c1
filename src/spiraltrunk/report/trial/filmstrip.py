"""A sheet of frames with a caption under each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from spiraltrunk.errors import ShapeError
from spiraltrunk.files.atomic import write_draft
from spiraltrunk.report.style import INK
from spiraltrunk.report.trial.frames import check_frame

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageFont import FreeTypeFont, ImageFont

    Font = FreeTypeFont | ImageFont

_LETTER_SHARE = 1 / 18
"""Size of a caption's letters over the width of a frame, legible on a page as wide as four frames."""


def write_filmstrip(
    path: str | Path, frames: Sequence[np.ndarray], captions: Sequence[str], columns: int = 4, *, title: str = ""
) -> Path:
    """Write a white sheet of frames in reading order, each over its caption; the path's ending sets the format.

    Args:
        path: file to write.
        frames: pictures of one size, shape (height, width, 3), 0 to 255.
        captions: one for each frame; what is wider than the frame goes on in a new line.
        columns: frames side by side, at most.
        title: head of the sheet.

    Raises:
        ShapeError: where frames differ in shape or type, or captions in number.
        OSError: where the file cannot be written.
    """
    sheet = build_filmstrip(frames, captions, columns, title=title)
    with write_draft(path) as draft:
        sheet.save(draft)
    return Path(path)


def build_filmstrip(
    frames: Sequence[np.ndarray], captions: Sequence[str], columns: int = 4, *, title: str = ""
) -> Image:
    """The sheet that write_filmstrip writes."""
    from PIL import Image, ImageDraw

    height, width = _check_frames(frames, captions, columns)
    size = max(10, round(width * _LETTER_SHARE))
    is_ascii = all(text.isascii() for text in (title, *captions))
    font, head = load_font(size, is_ascii=is_ascii), load_font(round(1.25 * size), is_ascii=is_ascii)
    lines = [wrap_caption(caption, font, width) for caption in captions]
    columns = min(columns, len(frames))
    rows = [range(first, min(first + columns, len(frames))) for first in range(0, len(frames), columns)]
    margin, line = size, round(1.3 * size)
    title_lines = wrap_caption(title, head, columns * (width + margin) - margin) if title else []
    title_line = round(1.5 * size)
    top = margin + (len(title_lines) * title_line + margin // 2 if title else 0)
    row_heights = [height + size // 3 + line * max(len(lines[i]) for i in row) + margin for row in rows]
    sheet = Image.new("RGB", (margin + columns * (width + margin), top + sum(row_heights)), "white")
    draw = ImageDraw.Draw(sheet)
    for k, text in enumerate(title_lines):
        draw.text((margin, margin + k * title_line), text, font=head, fill=INK)
    for row, row_height in zip(rows, row_heights, strict=True):
        for column, i in enumerate(row):
            left = margin + column * (width + margin)
            sheet.paste(Image.fromarray(np.ascontiguousarray(frames[i])), (left, top))
            for k, text in enumerate(lines[i]):
                at = (left + width / 2, top + height + size // 3 + k * line)
                draw.text(at, text, font=font, fill=INK, anchor="ma")
        top += row_height
    return sheet


def load_font(size: int, *, is_ascii: bool) -> Font:
    """Pillow's own font, or, as that lacks arrows and accents, matplotlib's; neither depends on the machine."""
    from PIL import ImageFont

    if is_ascii:
        return ImageFont.load_default(size=size)
    import matplotlib

    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", size=size)


def _check_frames(frames: Sequence[np.ndarray], captions: Sequence[str], columns: int) -> tuple[int, int]:
    """Height and width of the frames [pixels].

    Raises:
        ShapeError: where they differ, or captions are not as many.
    """
    if not frames:
        raise ShapeError("a film strip has 0 frames; allowed: at least 1")
    if len(captions) != len(frames):
        raise ShapeError(f"a film strip has {len(captions)} captions for {len(frames)} frames; allowed: one for each")
    if columns < 1:
        raise ShapeError(f"a film strip has {columns} columns; allowed: at least 1")
    shape = np.shape(frames[0])
    for i, frame in enumerate(frames):
        check_frame(frame, shape, f"frame {i}")
    return shape[0], shape[1]


def wrap_caption(caption: str, font: Font, width: float) -> list[str]:
    """Lines of a caption that fit a width [pixels]; a word that does not is broken."""
    lines: list[str] = []
    for paragraph in caption.splitlines():
        line = ""
        for word in paragraph.split():
            if line and font.getlength(f"{line} {word}") > width:
                lines.append(line)
                line = ""
            line = f"{line} {word}" if line else word
            while font.getlength(line) > width and len(line) > 1:
                fit = next((n for n in range(len(line) - 1, 1, -1) if font.getlength(line[:n]) <= width), 1)
                lines.append(line[:fit])
                line = line[fit:]
        lines.append(line)
    return lines
