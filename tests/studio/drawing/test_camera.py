"""Each tab keeps its own view, also where tabs are switched faster than the page reports its camera."""

from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.studio.drawing import camera as camera_module
from spiraltrunk.studio.drawing.camera import SETTLED, TabCamera


@pytest.fixture
def clock(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(camera_module.time, "monotonic", lambda: now[0])
    return now


@pytest.mark.parametrize(("shown", "is_kept"), [(0.5 * SETTLED, False), (1.5 * SETTLED, True)])
def test_a_view_is_kept_once_the_page_has_reported_it(clock, shown, is_kept):
    camera = SimpleNamespace()
    page = SimpleNamespace(client=SimpleNamespace(camera=camera, atomic=nullcontext))
    first, other = np.array([1.0, 2.0, 3.0]), np.array([9.0, 9.0, 9.0])
    own = TabCamera(page, first, np.zeros(3))
    own.show()
    assert np.array_equal(camera.position, first)
    camera.position = other  # As the tab before had it, or as a person has turned it.
    clock[0] += shown
    own.keep()
    own.show()
    assert np.array_equal(camera.position, other if is_kept else first)
