"""Videos of a camera: the pictures of many episodes one after another, at a constant rate from 0."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.errors import MissingPackage
from spiraltrunk.workflows.demos.dataset.lerobot.features import CHUNK, VIDEO_MB, VIDEO_PATH

_OPTIONS = {"crf": "18", "preset": "veryfast", "g": "2", "bf": "0"}
"""Constant rate factor, speed, key frames every second frame, as readers seek single frames, and no reordering."""


@final
class VideoFiles:
    """Writes the pictures of one camera; a context, which completes the last file."""

    def __init__(self, folder: Path, key: str, size: int, fps: int) -> None:
        self._folder, self._key, self._size, self._fps = folder, key, size, fps
        self._number, self._frames = -1, 0
        self._path = folder
        self._container: Any = None

    def __enter__(self) -> VideoFiles:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def add(self, pictures: Iterable[np.ndarray]) -> dict[str, float]:
        """Append an episode's pictures, and return where they are: the file, start and end in it [s].

        Raises:
            MissingPackage: where PyAV has no H.264 encoder.
            OSError: where the file cannot be written.
        """
        import av

        if self._container is None or self._path.stat().st_size >= 0.9 * VIDEO_MB * 2**20:
            self._open()
        first = self._frames
        for picture in pictures:
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24").reformat(format="yuv420p")
            frame.pts, frame.time_base = self._frames, 1 / Fraction(self._fps)
            self._container.mux(self._stream.encode(frame))
            self._frames += 1
        begin, end = first / self._fps, self._frames / self._fps
        chunk, file = divmod(self._number, CHUNK)
        return {"chunk_index": chunk, "file_index": file, "from_timestamp": begin, "to_timestamp": end}

    def _open(self) -> None:
        import av

        self._close()
        self._number, self._frames = self._number + 1, 0
        chunk, file = divmod(self._number, CHUNK)
        self._path = self._folder / VIDEO_PATH.format(video_key=self._key, chunk_index=chunk, file_index=file)
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._container = av.open(str(self._path), "w", format="mp4")
        try:
            self._stream = self._container.add_stream("libx264", rate=self._fps, options=_OPTIONS)
        except av.codec.codec.UnknownCodecError:
            raise MissingPackage("this PyAV has no H.264 encoder: pip install --force-reinstall av") from None
        self._stream.width = self._stream.height = self._size
        self._stream.pix_fmt = "yuv420p"

    def _close(self) -> None:
        if self._container is not None:
            self._container.mux(self._stream.encode(None))
            self._container.close()
            self._container = None
