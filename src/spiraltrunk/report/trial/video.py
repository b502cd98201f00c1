"""H.264 videos, encoded frame by frame."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from spiraltrunk.errors import MissingPackage, ShapeError
from spiraltrunk.files.atomic import atomic_file

if TYPE_CHECKING:
    from av import VideoStream
    from av.container import OutputContainer

_ENCODER: Final = "libx264"
"""The H.264 encoder in PyAV's wheels."""

_QUALITY = {"crf": "23", "preset": "veryfast"}
"""Constant rate factor of x264 (0 lossless to 51 worst) and its preset of speed against size."""

_BT709 = 1
"""Number of ITU-R BT.709 as matrix, primaries and transfer curve (ITU-T H.273)."""

_LIMITED = 1
"""Number of the range 16 to 235 in FFmpeg, which players expect of H.264."""


def write_video(path: str | Path, frames: Iterable[np.ndarray], fps: int = 25) -> Path:
    """Write an MP4 video that plays while it loads; of odd sizes the last row or column is cut off.

    Args:
        path: file to write.
        frames: pictures of one size, shape (height, width, 3), 0 to 255. No file is left where they raise.
        fps: frames per second.

    Raises:
        ShapeError: where there is no frame.
        MissingPackage: where PyAV has no H.264 encoder.
        OSError: where the file cannot be written.
    """
    import av

    frames = iter(frames)
    first = next(frames, None)
    if first is None:
        raise ShapeError("a video has 0 frames; allowed: at least 1")
    options = {"movflags": "+faststart"}
    with atomic_file(path) as draft, av.open(str(draft), "w", format="mp4", options=options) as container:
        stream = _add_stream(container, first.shape, fps)
        for i, picture in enumerate(chain([first], frames)):
            even = np.ascontiguousarray(picture[: stream.height, : stream.width])
            frame = av.VideoFrame.from_ndarray(even, format="rgb24").reformat(
                format="yuv420p", dst_colorspace=_BT709, dst_color_range=_LIMITED
            )
            frame.pts, frame.time_base = i, 1 / Fraction(fps)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return Path(path)


def _add_stream(container: OutputContainer, shape: tuple[int, ...], fps: int) -> VideoStream:
    import av

    try:
        stream = container.add_stream(_ENCODER, rate=fps, options=_QUALITY)
    except av.codec.codec.UnknownCodecError:
        raise MissingPackage("this PyAV has no H.264 encoder: pip install --force-reinstall av") from None
    stream.height, stream.width = shape[0] // 2 * 2, shape[1] // 2 * 2
    stream.pix_fmt = "yuv420p"
    context = stream.codec_context
    context.colorspace, context.color_primaries, context.color_trc = _BT709, _BT709, _BT709
    context.color_range = _LIMITED
    return stream
