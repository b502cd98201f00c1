"""The table bears the object at both ends, and lets the trunk out between them."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.scene.supports import SLOT, add_table

PLACE = np.array([0.4, 0.1, 0.3])


def build_table(length: float, width: float = 0.06) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The table for a round object of a length, which lies in its place along x."""
    shape = replace(parse_object("cylinder-60"), size=(length, width, width))
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(
        name="object", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[width / 2, length / 2, 0.0], pos=PLACE,
        quat=[np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0],
    )  # fmt: skip
    add_table(spec, SceneOptions(shape=shape), PLACE)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("length", [0.08, 0.12, 0.15, 0.20, 0.30])
def test_an_object_bridges_the_slot(length: float) -> None:
    """It bears on 3.5 cm and more at either end, does not stand out, and the slot is as wide as that allows."""
    model, _ = build_table(length)
    middle = {name: model.geom(f"table_{name}_front").pos[0] - PLACE[0] for name in ("near", "far")}
    half = float(model.geom("table_near_front").size[0])
    assert middle["near"] == pytest.approx(-middle["far"])
    slot, end = middle["far"] - half, middle["far"] + half
    assert slot == pytest.approx(min(SLOT, length / 2 - 0.035))
    assert end > length / 2


@pytest.mark.parametrize("width", [0.03, 0.06, 0.12])
def test_a_round_object_in_its_place_touches_all_four_boards(width: float) -> None:
    model, data = build_table(0.2, width)
    boards = [f"table_{side}_{part}" for side in ("near", "far") for part in ("front", "back")]
    for name in boards:
        apart = mujoco.mj_geomDistance(model, data, model.geom("object").id, model.geom(name).id, 1.0, None)
        assert apart == pytest.approx(0.0, abs=1e-6)
