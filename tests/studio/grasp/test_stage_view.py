"""What the robot's scene looks like on light and dark ground."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from spiraltrunk.studio.grasp.stage_view import StageView

from .conftest import build_recording


class FakeScene:
    """Keeps the nodes that are drawn."""

    def __init__(self):
        self.nodes = {}

    def add_mesh_simple(self, name, vertices, faces, color, cast_shadow):
        self.nodes[name] = SimpleNamespace(name=name, color=color)
        return self.nodes[name]

    def add_line_segments(self, name, points, color, thickness):
        return SimpleNamespace(points=points)

    def add_frame(self, name, show_axes):
        return SimpleNamespace(remove=self.nodes.clear)


@pytest.mark.parametrize("is_dark_first", [False, True])
def test_the_floor_alone_is_darker_on_dark_ground(is_dark_first):
    recording, scene = build_recording(), FakeScene()
    floor, ball = (mesh.color for mesh in recording.meshes.meshes)
    view = StageView(scene, "/stage", is_dark=is_dark_first)
    view.draw(recording.meshes, recording.frames)

    def read():
        return scene.nodes["/stage/body_0"].color, scene.nodes["/stage/body_1"].color

    for is_dark in (is_dark_first, not is_dark_first, is_dark_first):
        view.set_dark(is_dark)
        shown, ball_shown = read()
        assert ball_shown == ball
        assert max(shown) < 0.5 * min(floor) if is_dark else shown == floor
    view.draw(recording.meshes, recording.frames)
    assert max(read()[0]) < 0.5 * min(floor) if is_dark_first else read()[0] == floor
