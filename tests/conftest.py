"""Settings for all tests, and the order in which two processes share them."""

from __future__ import annotations

import ctypes.util
import fcntl
import functools
import os
from collections.abc import Generator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from spiraltrunk.cli import progress
from spiraltrunk.design import presets
from spiraltrunk.errors import MissingPackage
from spiraltrunk.model import inverse, reference, statics

if not os.environ.get("MUJOCO_GL") and not os.environ.get("DISPLAY") and ctypes.util.find_library("EGL"):
    os.environ["MUJOCO_GL"] = "egl"  # As the commands do; MuJoCo reads it once, when it is imported.

settings.register_profile("spiraltrunk", deadline=None, print_blob=True, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("fast", settings.get_profile("spiraltrunk"), max_examples=40)
settings.load_profile("spiraltrunk")

HERE = Path(__file__).parent
WITHOUT_MODELS = (
    "hardware/safety/", "hardware/driver/",
    "architecture/", "cad/", "cli/test_design", "cli/test_grasp", "cli/test_signals", "cli/test_survey", "design/",
    "report/trial/test_figures", "sim/objects/", "sim/relaxation/", "sim/robot/test_arm", "sim/robot/test_trunk",
    "sim/test_grasp", "sim/test_p", "strategies/push/test_push", "strategies/test_strategies", "workflows/survey/",
)  # fmt: skip
"""Folders and files of tests that no model is compiled for."""


progress.SLOW = 1e6
"""What takes long on a busy computer is not told: no test depends on the time that it takes."""


def pytest_configure(config: pytest.Config) -> None:
    """Fewer examples of each law among the fast tests; every run draws others, and `make test-all` draws 100."""
    if config.option.markexpr == "not slow":
        settings.load_profile("fast")


def uses_models(item: pytest.Item) -> bool:
    """Whether what the models are compiled to may be needed."""
    path = item.path.relative_to(HERE).as_posix()
    return not path.startswith(WITHOUT_MODELS)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests without models in the middle: of two processes one starts there, while the other compiles the models.

    Last of these hooks, when what is not to be run has gone, and with some to spare, as the two halves differ by a few.
    """
    with_models = [item for item in items if uses_models(item)]
    without = [item for item in items if not uses_models(item)]
    first = min(max(len(items) // 2 - 16, 0), len(with_models))
    items[:] = with_models[:first] + without + with_models[first:]


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Outside the time that a test has, compile what it may need, in one process alone: another one waits for it."""
    if uses_models(item) and not item.config.stash.get(IS_COMPILED, False):
        lock = os.open(HERE, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            compile_models()
        finally:
            os.close(lock)
        item.config.stash[IS_COMPILED] = True
    return (yield)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what renders, where there is no OpenGL."""
    if item.get_closest_marker("gl") and (missing := find_missing_opengl()):
        pytest.skip(missing)


@functools.cache
def find_missing_opengl() -> str:
    """Why no picture can be rendered here; empty where one can."""
    import mujoco

    from spiraltrunk.sim.render import View, open_renderer

    try:
        open_renderer(mujoco.MjModel.from_xml_string("<mujoco/>"), View(width=16, height=16)).close()
    except MissingPackage as error:
        return str(error)
    return ""


IS_COMPILED = pytest.StashKey[bool]()


def compile_models() -> None:
    """Call what the models compile; found on disc, it takes no time."""
    design = presets.PAPER
    reference.bend_dorsal(design, 0.05, 0.4)
    reference.bend_dorsal_points(design, [0.05], 0.4)
    statics.solve(design, tension=[1.0, 0.0, 0.0])
    inverse.solve(design, [0.1, -0.4, 0.0])
