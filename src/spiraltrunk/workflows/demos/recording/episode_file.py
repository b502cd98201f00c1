"""Files of episodes: NumPy's zipped arrays without pickles, each written as a whole when its trial ends."""

from __future__ import annotations

import json
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

import numpy as np

from spiraltrunk.errors import OutputError
from spiraltrunk.files.atomic import write_file
from spiraltrunk.workflows.demos.recording import frames
from spiraltrunk.workflows.demos.recording.episode import ARRAYS, OF_COMMANDS, Episode

FOLDER = "episodes"
"""Name of their folder."""

_DIGITS = 6
"""Digits of a trial's number in the name of its file [-] (ours)."""

_FRAMES = "frames_"
"""How the names of frames in the file begin."""

_VIDEO = "video_"
"""How the names of videos in the file begin."""


def name_episode(strategy: str, index: int | Literal["*"]) -> str:
    """Name of the file of a trial, or the pattern of all files of a strategy.

    What does not belong in a file's name, as of the path of a policy, is percent-encoded. The pattern asks for digits
    alone, since a strategy's name may begin with another's.
    """
    number = "[0-9]" * _DIGITS if index == "*" else f"{index:0{_DIGITS}d}"
    return f"{quote(strategy, safe='')}-{number}.npz"


def write_episode(episode: Episode, path: Path) -> None:
    """Write an episode; whatever happens, there is the whole file or none.

    Raises:
        OutputError: where it cannot be written.
    """
    texts = {"about": json.dumps(episode.about, allow_nan=False).encode(), "scene": episode.scene.encode()}
    raw = texts | {_VIDEO + name: video for name, video in episode.videos.items()}
    arrays: dict[str, Any] = {name: getattr(episode, name) for name in ARRAYS}
    arrays |= {_FRAMES + name: getattr(episode.frames, name) for name in frames.ARRAYS}
    arrays |= {name: np.frombuffer(content, np.uint8) for name, content in raw.items()}
    file = BytesIO()
    np.savez_compressed(file, **arrays)
    try:
        write_file(path, file.getvalue())
    except OSError as error:
        allowed = "allowed: a place that can be written"
        raise OutputError(f"{str(path)!r} cannot be written: {error.strerror}; {allowed}") from None


def load_episode(path: Path) -> Episode:
    """Read an episode.

    Raises:
        OutputError: where there is none, or it is damaged.
    """
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in ARRAYS}
            encoded = frames.Frames(**{name: stored[_FRAMES + name] for name in frames.ARRAYS})
            videos = {name[len(_VIDEO) :]: stored[name].tobytes() for name in stored.files if name.startswith(_VIDEO)}
            about, scene = (stored[name].tobytes().decode() for name in ("about", "scene"))
        episode = Episode(about=dict(json.loads(about)), scene=scene, videos=videos, frames=encoded, **arrays)
        _check(episode)
    except FileNotFoundError:
        raise OutputError(f"{str(path)!r} is gone; allowed: the folder with all its episodes, or a new one") from None
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
        allowed = "allowed: the same command once that file is removed, which records it again"
        raise OutputError(f"{str(path)!r} is no episode; {allowed}") from None
    return episode


def _check(episode: Episode) -> None:
    """Refuse arrays that do not belong together.

    Raises:
        ValueError: where their lengths differ.
    """
    count = len(episode)
    lengths = {name: len(getattr(episode, name)) for name in ARRAYS}
    if any(length != count + (name not in OF_COMMANDS) for name, length in lengths.items()):
        raise ValueError("lengths differ")
    shown = len(episode.steps)
    if any(len(each) != shown for each in (episode.frames.agent, episode.frames.environment)):
        raise ValueError("lengths of frames differ")
    if len(episode.frames) != shown - 1:
        raise ValueError("another number of actions")
