"""A video plays: as many frames, as large and of the colours that went in."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from spiraltrunk.errors import MissingPackage, ShapeError
from spiraltrunk.report import write_video

LEFT, RIGHT = (200, 40, 30), (30, 70, 190)


def build_frames(n: int, height: int = 48, width: int = 64) -> Iterator[np.ndarray]:
    """A red left and a blue right, and a white bar that goes down."""
    for i in range(n):
        frame = np.empty((height, width, 3), dtype=np.uint8)
        frame[:, : width // 2], frame[:, width // 2 :] = LEFT, RIGHT
        frame[i % height] = 255
        yield frame


@pytest.mark.parametrize("size", [(48, 64), (49, 65)])
def test_video_reads_back(tmp_path: Path, size: tuple[int, int]) -> None:
    path = write_video(tmp_path / "new" / "run.mp4", build_frames(30, *size), fps=20)
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.pix_fmt) == ("h264", "yuv420p")
        assert (stream.height, stream.width) == (48, 64)
        assert stream.average_rate == 20
        frames = list(container.decode(stream))
    assert len(frames) == 30
    assert [frame.pts * frame.time_base for frame in frames] == [Fraction(i, 20) for i in range(30)]
    last = frames[-1].to_ndarray(format="rgb24")
    np.testing.assert_allclose(last[4:20, 8:24].mean(axis=(0, 1)), LEFT, atol=12)
    np.testing.assert_allclose(last[4:20, 40:56].mean(axis=(0, 1)), RIGHT, atol=12)
    assert last[29].mean() > 200
    assert list(path.parent.iterdir()) == [path]


def test_video_says_how_colors_are_meant(tmp_path: Path) -> None:
    with av.open(str(write_video(tmp_path / "run.mp4", build_frames(2)))) as container:
        frame = next(container.decode(video=0))
        assert (frame.colorspace, frame.color_range) == (1, 1)  # BT.709, 16 to 235.


def test_video_starts_while_it_loads(tmp_path: Path) -> None:
    data = write_video(tmp_path / "run.mp4", build_frames(3)).read_bytes()
    assert 0 < data.index(b"moov") < data.index(b"mdat")


def test_frames_are_not_kept(tmp_path: Path) -> None:
    alive: list[weakref.ref[np.ndarray]] = []
    most = 0

    def watch() -> Iterator[np.ndarray]:
        nonlocal most
        for i in range(40):
            frame = np.full((48, 64, 3), i, dtype=np.uint8)
            alive.append(weakref.ref(frame))
            most = max(most, sum(ref() is not None for ref in alive))
            yield frame

    write_video(tmp_path / "run.mp4", watch())
    assert most <= 4


@pytest.mark.parametrize("n", [0, 1, 12])
def test_failing_iterator_leaves_nothing(tmp_path: Path, n: int) -> None:
    def fail() -> Iterator[np.ndarray]:
        yield from build_frames(n)
        raise RuntimeError("the renderer broke")

    with pytest.raises(RuntimeError, match="the renderer broke"):
        write_video(tmp_path / "run.mp4", fail())
    assert list(tmp_path.iterdir()) == []


def test_failure_keeps_the_old_video(tmp_path: Path) -> None:
    path = write_video(tmp_path / "run.mp4", build_frames(2))
    before = path.read_bytes()

    def fail() -> Iterator[np.ndarray]:
        yield from build_frames(2)
        raise RuntimeError("the renderer broke")

    with pytest.raises(RuntimeError, match="the renderer broke"):
        write_video(path, fail())
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_no_frames_leave_no_file(tmp_path: Path) -> None:
    with pytest.raises(ShapeError, match="0 frames"):
        write_video(tmp_path / "run.mp4", [])
    assert list(tmp_path.iterdir()) == []


def test_missing_encoder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from spiraltrunk.report.trial import video

    monkeypatch.setattr(video, "_ENCODER", "no_such_encoder")
    with pytest.raises(MissingPackage, match=r"no H\.264 encoder"):
        write_video(tmp_path / "run.mp4", build_frames(2))
    assert list(tmp_path.iterdir()) == []
