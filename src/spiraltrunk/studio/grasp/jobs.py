"""Jobs of the tab; each function runs in a process of its own and is called as ``work(report, ...)``."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, final

from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Status
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.body_meshes import ModelMeshes, build_meshes
from spiraltrunk.sim.objects.catalogue import ObjectSpec, load_mesh
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.studio.grasp.request import GraspRequest
from spiraltrunk.workflows.grasp.artifacts import compute_result
from spiraltrunk.workflows.grasp.choice.auto import get_strategy
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.choice.refusal import explain_choice, find_refusal
from spiraltrunk.workflows.grasp.pictures import write_film, write_strip
from spiraltrunk.workflows.grasp.recording import START, Frames, Recorder, Recording
from spiraltrunk.workflows.grasp.trial import Trial, build_plant, run_plant, run_trial
from spiraltrunk.workflows.grasp.world import draw_scene

REPORT_PERIOD = 0.1
"""Least time between two reports of frames [s]."""

VIDEO_WORKERS = 2
"""Processes that render a video."""

Report = Callable[[Any], None]


@final
@dataclass(frozen=True, kw_only=True)
class Scene:
    """The scene of a trial before anything moves."""

    meshes: ModelMeshes
    """Surfaces of the bodies."""
    frames: Frames
    """The one frame."""


@final
@dataclass(frozen=True, kw_only=True)
class Progress:
    """Progress of a job."""

    step: str
    """Present step."""
    done: int
    """Parts that are done."""
    total: int
    """All parts; 0 where that is not known."""


def prepare(report: Report, request: GraspRequest) -> tuple[Candidate, ...]:
    """Report the scene of a trial, then return what the models predict for all strategies of its stage."""
    report(build_scene(request))
    return explain_choice(request.design, request.shape, request.stage, request.name)


def build_scene(request: GraspRequest) -> Scene:
    """The scene of a trial; where the strategy has no plan for the object, the ground is the usual one."""
    strategy = get_strategy(request.strategy, request.design, request.shape, request.stage)
    options = draw_scene(request.shape, request.seed, strategy=strategy)
    try:
        plant = build_plant(request.design, options, strategy)
    except ModelError:
        plant = SimPlant(request.design, options)
    plant.reset()
    recorder = Recorder(plant)
    recorder.add(plant.trace[0], Status(phase="reach", action=START))
    frames = recorder.take()
    assert frames is not None
    return Scene(meshes=build_meshes(plant.model), frames=frames)


def run_grasp(report: Report, request: GraspRequest) -> dict[str, Any]:
    """Run a trial, report its meshes, then its frames as they are computed, and return its result.

    Raises:
        ModelError: where the strategy cannot take the object, or cannot plan for it.
        RunError: where the simulation diverges.
    """
    strategy = get_strategy(request.strategy, request.design, request.shape, request.stage)
    refusal = find_refusal(strategy, request.design, request.shape, request.name)
    if refusal is not None:
        raise ModelError(refusal)
    options = draw_scene(request.shape, request.seed, strategy=strategy)
    plant = build_plant(request.design, options, strategy)
    report(build_meshes(plant.model))
    recorder, reported = Recorder(plant), 0.0

    def watch(observation: Observation, status: Status) -> None:
        nonlocal reported
        recorder.watch(observation, status)
        now = time.monotonic()
        if now - reported >= REPORT_PERIOD:
            reported = now
            _report_frames(report, recorder)

    trial = run_plant(plant, strategy, seed=request.seed, watch=watch)
    _report_frames(report, recorder)
    return compute_result(trial, request.name)


def _report_frames(report: Report, recorder: Recorder) -> None:
    frames = recorder.take()
    if frames is not None:
        report(frames)


def read_upload(report: Report, content: bytes, form: str, mass: float, options: dict[str, str]) -> ObjectSpec:
    """The object of an uploaded STL or OBJ file, with what was guessed and repaired in its notes.

    The name that the browser gave is not used: the file gets one of ours.

    Args:
        report: unused.
        content: the file.
        form: stl or obj.
        mass: mass of the object [kg].
        options: unit, axis and collide, as of `load_mesh`.

    Raises:
        DesignError: for a file that cannot be read, or is no solid of 5 mm to 1 m.
    """
    with TemporaryDirectory(prefix="spiraltrunk-") as folder:
        path = Path(folder) / f"object.{form}"
        path.write_bytes(content)
        return load_mesh(str(path), mass=mass, form=form, **options)


def draw_strip(report: Report, request: GraspRequest) -> bytes:
    """Film strip of a trial, which is run again: the same seed gives the same trial."""
    return _draw(report, request, "filmstrip.png", lambda trial, path: write_strip(trial, path, title=request.title))


def draw_film(report: Report, request: GraspRequest) -> bytes:
    """Video of a trial, which is run again: the same seed gives the same trial."""

    def tell(step: str, done: int, total: int) -> None:
        report(Progress(step=step, done=done, total=total))

    return _draw(report, request, "grasp.mp4", lambda trial, path: write_film(trial, path, VIDEO_WORKERS, tell))


def _draw(report: Report, request: GraspRequest, name: str, write: Callable[[Trial, Path], None]) -> bytes:
    report(Progress(step="trial again", done=0, total=0))
    trial = run_trial(request.design, request.shape, strategy=request.strategy, stage=request.stage, seed=request.seed)
    report(Progress(step="pictures", done=0, total=0))
    with TemporaryDirectory(prefix="spiraltrunk-") as folder:
        path = Path(folder) / name
        write(trial, path)
        return path.read_bytes()


def draw_replay(report: Report, recording: Recording) -> bytes:
    """Replay of a recording, as an HTML page."""
    from spiraltrunk.studio.grasp.replay import format_replay

    report(Progress(step="replay", done=0, total=0))
    return format_replay(recording).encode()
