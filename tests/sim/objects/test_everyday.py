"""Everyday shapes: measures within their ranges, plausible masses, the same for the same seed, accepted by MuJoCo."""

import mujoco
import numpy as np
import pytest

from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.sim.objects.catalogue import add_object, parse_object
from spiraltrunk.sim.objects.description import compute_volume
from spiraltrunk.sim.objects.everyday import DENSITIES, FAMILIES, GRAMS, HEIGHTS, WIDTHS, draw_everyday, draw_object

HANDLE = 1.5
"""Largest width with a handle over that without."""


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", range(12))
def test_every_drawn_object_holds_its_measures_and_compiles(family, seed):
    drawn = draw_everyday(np.random.default_rng(seed), kind=family)
    length, deep, wide = drawn.shape.size
    assert drawn.family == family
    assert HEIGHTS[0] * 0.999 <= length <= HEIGHTS[1] * 1.001
    assert WIDTHS[0] * 0.98 <= min(deep, wide)
    assert max(deep, wide) <= WIDTHS[1] * (HANDLE if family == "handled" else 1) * 1.001
    assert GRAMS[0] <= drawn.shape.mass <= GRAMS[1]
    density = drawn.shape.mass / compute_volume(drawn.shape)
    is_bound = drawn.shape.mass in {GRAMS[0], GRAMS[1]} or np.isclose(drawn.shape.mass, GRAMS).any()
    assert DENSITIES[0] * 0.999 <= density <= DENSITIES[1] * 1.001 or is_bound
    spec = mujoco.MjSpec()
    body = add_object(spec, drawn.shape)
    model = spec.compile()
    assert model.body("object").mass[0] == pytest.approx(drawn.shape.mass)
    stated, own = model.body("object"), drawn.shape
    body.explicitinertial = False
    for geom, part in zip(body.geoms, own.solid.geoms, strict=True):
        geom.density = own.mass / compute_volume(own)
        geom.mass = np.nan
        if part.form == "mesh":
            spec.mesh(geom.meshname).inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT
    integrated = spec.compile().body("object")
    np.testing.assert_allclose(integrated.mass, stated.mass, rtol=1e-4)
    np.testing.assert_allclose(integrated.ipos, stated.ipos, atol=1e-5)
    np.testing.assert_allclose(np.sort(integrated.inertia), np.sort(stated.inertia), rtol=1e-3)


def test_the_same_seed_draws_the_same_object():
    one, other = (draw_object(np.random.default_rng(5)) for _ in range(2))
    assert (one.size, one.mass, one.kind) == (other.size, other.mass, other.kind)
    assert parse_object("everyday:seed=5").size == one.size


def test_a_survey_of_seeds_draws_every_class():
    assert {draw_everyday(np.random.default_rng(seed)).family for seed in range(40)} == set(FAMILIES)


def test_ranges_that_are_asked_for_hold():
    rng = np.random.default_rng(1)
    for _ in range(20):
        shape = draw_object(rng, kind="cylinder", width=(0.04, 0.05), height=(0.08, 0.1), mass=(0.1, 0.12))
        assert 0.08 <= shape.length <= 0.1
        assert 0.04 <= shape.width <= 0.05
        assert 0.1 <= shape.mass <= 0.12


def test_other_classes_and_ranges_are_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(UnknownName, match="known: cylinder, box, superquadric, revolution, handled"):
        draw_object(rng, kind="teapot")
    for bounds in ((0.1, 0.05), (0.001, 0.1), (0.05, np.inf), (0.05,), 0.05):
        with pytest.raises(DesignError, match=r"everyday\.width"):
            draw_object(rng, width=bounds)


def test_the_text_form_takes_a_seed_and_a_class():
    shape = parse_object("everyday:seed=7,kind=handled")
    assert shape.kind == "solid"
    assert shape.notes[0].startswith("drawn: a ")
    bad = {"seed=-1": "object.seed is '-1'; allowed", "seed=1e3": "object.seed", "seed=": "object.seed",
           "seed=7,mass_g=3": "unknown measure of everyday 'mass_g'; known: seed, kind, pose"}  # fmt: skip
    for text, match in bad.items():
        with pytest.raises((DesignError, UnknownName), match=match):
            parse_object(f"everyday:{text}")
