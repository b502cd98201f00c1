"""Pictures of an episode: rendered from the simulator's states after the trial, stored as lossless videos."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from fractions import Fraction
from io import BytesIO
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from spiraltrunk.errors import MissingPackage
from spiraltrunk.sim.photographer import Photographer
from spiraltrunk.workflows.demos.recording.frames import choose_steps

if TYPE_CHECKING:
    from av import VideoStream
    from av.container import OutputContainer

    from spiraltrunk.sim.machine import SimMachine
    from spiraltrunk.workflows.demos.options import RecordingOptions

_ENCODER: Final[Literal["libx264rgb"]] = "libx264rgb"
"""Encoder of H.264 that stores red, green and blue as they are."""

_LOSSLESS = {"qp": "0", "preset": "veryfast"}
"""Options by which every pixel is kept."""


def record_videos(
    machine: SimMachine, positions: Sequence[np.ndarray], recording: RecordingOptions
) -> dict[str, bytes]:
    """A lossless video of each camera, with the pictures that the environments give of the same states.

    Args:
        machine: the machine that is seen.
        positions: its generalised positions at all observations, each of shape (n_q,).
        recording: cameras, size and rate.

    Raises:
        MissingPackage: where there is no OpenGL, or no encoder.
    """
    if not recording.cameras:
        return {}
    shown = [positions[step] for step in choose_steps(len(positions) - 1, recording.stride)]
    with closing(Photographer(machine, (recording.size, recording.size))) as photographer:

        def take(camera: str) -> Iterator[np.ndarray]:
            for each in shown:
                photographer.pose(each)
                yield photographer.take(camera)

        return {camera: encode_lossless(take(camera), recording.fps) for camera in recording.cameras}


def encode_lossless(frames: Iterable[np.ndarray], fps: int) -> bytes:
    """A video file that keeps every pixel of its frames, each of shape (height, width, 3), 0 to 255.

    Raises:
        MissingPackage: where PyAV has no encoder for it.
    """
    import av

    file = BytesIO()
    with av.open(file, "w", format="mp4") as container:
        stream: VideoStream | None = None
        for i, picture in enumerate(frames):
            stream = _add_stream(container, picture.shape, fps) if stream is None else stream
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            frame.pts, frame.time_base = i, 1 / Fraction(fps)
            container.mux(stream.encode(frame))
        if stream is not None:
            container.mux(stream.encode(None))
    return file.getvalue()


def _add_stream(container: OutputContainer, shape: tuple[int, ...], fps: int) -> VideoStream:
    import av

    try:
        stream = container.add_stream(_ENCODER, rate=fps, options=_LOSSLESS)
    except av.codec.codec.UnknownCodecError:
        raise MissingPackage("this PyAV has no H.264 encoder: pip install --force-reinstall av") from None
    stream.height, stream.width = shape[:2]
    stream.pix_fmt = "rgb24"
    return stream


def decode(video: bytes) -> Iterator[np.ndarray]:
    """The frames of a lossless video, each of shape (height, width, 3), 0 to 255.

    Raises:
        OSError: where it is none; ValueError as well.
    """
    import av

    with av.open(BytesIO(video), "r") as container:
        for frame in container.decode(video=0):
            yield frame.to_ndarray(format="rgb24")
