"""A short recording without a simulation, and work that runs in threads of the test."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")

import trimesh

from spiraltrunk.sim.body_meshes import BodyMesh, ModelMeshes
from spiraltrunk.studio.grasp.jobs import Scene
from spiraltrunk.studio.page.job import STOPPED
from spiraltrunk.studio.page.page import Page
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.recording import RATE, Frames, Recording

SECONDS = 3
PHASES = ("reach", "prehension", "transport", "release")
RESULT = {
    "strategy": "wrap-vertical", "object": "cylinder-60", "seed": 0, "success": True, "reason": "success",
    "cause": None, "cause_time_s": None, "lift_m": 0.2, "carry_m": 0.2, "hold_s": 3.0, "place_error_m": 0.004,
    "max_joint_deg": 30.0, "max_penetration_m": 1e-3, "real_time_factor": 5.0,
    "world": {"friction": 0.8, "width_m": 0.06, "mass_kg": 0.25},
}  # fmt: skip


def build_recording(seconds=SECONDS, title="wrap-vertical, ball, seed 0: success"):
    """A large ball that moves aside and up before the camera."""
    ball, floor = trimesh.creation.icosphere(subdivisions=2, radius=0.25), trimesh.creation.box((2.0, 2.0, 0.01))
    meshes = tuple(
        BodyMesh(body=body, vertices=mesh.vertices.astype(np.float32), faces=mesh.faces.astype(np.int32), color=color)
        for body, (mesh, color) in enumerate(((floor, (200, 200, 200)), (ball, (213, 94, 0))))
    )
    time = np.arange(seconds * RATE + 1) / RATE
    share = time / time[-1]
    pose = np.zeros((len(time), 2, 7), np.float32)
    pose[..., 3] = 1.0
    pose[:, 1, 1], pose[:, 1, 2] = 0.8 * share - 0.3, 0.7 + 0.6 * share
    ends = np.zeros((len(time), 1, 2, 3), np.float32)
    ends[:, 0, 0], ends[:, 0, 1] = (0.0, 0.0, 2.0), pose[:, 1, :3]
    phase = tuple(PHASES[min(3, int(4 * each))] for each in share)
    frames = Frames(
        time=time, pose=pose, string=ends, tension=np.outer(share, [30.0, 20.0, 10.0]), height=0.7 + 0.6 * share,
        grip_force=40.0 * share, phase=phase, action=tuple(f"{name} it" for name in phase),
    )  # fmt: skip
    return Recording(title=title, meshes=ModelMeshes(meshes=meshes, n_body=2, string_radius=0.002), frames=frames)


def cut(frames, first, last):
    arrays = ("time", "pose", "string", "tension", "height", "grip_force", "phase", "action")
    return replace(frames, **{name: getattr(frames, name)[first:last] for name in arrays})


@pytest.fixture
def recording():
    return build_recording()


class FakeJob:
    def __init__(self):
        self.is_stopped = threading.Event()

    def stop(self):
        self.is_stopped.set()


@pytest.fixture
def fakes(monkeypatch, recording):
    """Replaces the simulation: a run waits in its middle for ``fakes.go``."""

    class Fakes:
        def __init__(self):
            self.go, self.requests = threading.Event(), []

        def prepare(self, job, report, request):
            self.requests.append(request)
            report(Scene(meshes=recording.meshes, frames=cut(recording.frames, 0, 1)))
            fits = request.shape.width > 0.033
            reason = "60 mm wide" if fits else "too thin for the trunk"
            return (Candidate(strategy="wrap-vertical", feasible=fits, score=0.98 * fits, reason=reason),)

        def run_grasp(self, job, report, request):
            report(recording.meshes)
            middle, last = len(recording.frames) // 2, len(recording.frames)
            report(cut(recording.frames, 0, middle))
            while not self.go.wait(0.02) and not job.is_stopped.is_set():
                pass
            if job.is_stopped.is_set():
                return None
            report(cut(recording.frames, middle, last))
            return RESULT

    fakes = Fakes()

    def start(page, work, *arguments, on_report, on_end):
        job = FakeJob()

        def report(value):
            page.post(lambda: on_report(value))

        def go():
            result, reason = None, None
            try:
                fake = getattr(fakes, work.__name__, None)
                result = work(report, *arguments) if fake is None else fake(job, report, *arguments)
            except Exception as error:
                reason = str(error)
            page.post(lambda: on_end(result, STOPPED if job.is_stopped.is_set() else reason))

        threading.Thread(target=go, daemon=True).start()
        return job

    monkeypatch.setattr(Page, "start", start)
    return fakes
