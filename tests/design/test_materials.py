"""The filament of the rigid parts: chosen in the design file, and followed by masses and inertias of the models."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from spiraltrunk.design import load_design, presets, write_design
from spiraltrunk.design.materials import PETG, RIGID
from spiraltrunk.design.mount import HOUSING_MASS, NECK_MASS, PRINTED_MASS
from spiraltrunk.errors import DesignError


def choose(name, **changes):
    return replace(presets.PAPER, housing=replace(presets.PAPER.housing, material=name, **changes))


def test_the_default_weighs_what_the_design_says():
    assert presets.PAPER.housing.total_mass == HOUSING_MASS
    assert presets.PAPER.housing.total_neck_mass == NECK_MASS


@pytest.mark.parametrize("name", RIGID)
def test_masses_follow_the_density(name):
    housing, ratio = choose(name).housing, RIGID[name].density / PETG.density
    assert housing.total_neck_mass == pytest.approx(NECK_MASS * ratio)
    assert housing.total_mass - HOUSING_MASS == pytest.approx(PRINTED_MASS * (ratio - 1), abs=1e-12)


def test_what_was_weighed_goes_before_the_material():
    housing = choose("ASA", mass=2.0, neck_mass=0.1).housing
    assert (housing.total_mass, housing.total_neck_mass) == (2.0, 0.1)


def test_the_file_keeps_the_material(tmp_path):
    path = write_design(choose("PLA"), tmp_path / "trunk.toml")
    assert 'material = "PLA"' in path.read_text()
    assert load_design(path) == choose("PLA")
    path.write_text(path.read_text().replace('"PLA"', '"wood"'))
    with pytest.raises(DesignError, match=r"housing\.material is 'wood'; allowed: PETG, PLA, ASA"):
        load_design(path)


def test_mass_and_inertia_of_the_model_follow():
    from spiraltrunk.sim.robot.trunk import add_housing

    def measure(design):
        spec = mujoco.MjSpec()
        add_housing(spec.worldbody, design, np.zeros(3), np.array([1.0, 0, 0, 0]))
        model = spec.compile()
        bodies = [model.body(name) for name in ("housing", "neck")]
        return np.array([[body.mass[0], *body.inertia] for body in bodies])

    petg, asa = measure(presets.PAPER), measure(choose("ASA"))
    housing = choose("ASA").housing
    ratio = np.array([housing.total_mass / HOUSING_MASS, housing.total_neck_mass / NECK_MASS])
    assert (ratio < 1).all()
    np.testing.assert_allclose(asa / petg, np.repeat(ratio[:, None], 4, axis=1), rtol=1e-9)
