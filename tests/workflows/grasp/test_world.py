"""Worlds of trials: what is drawn stays within what objects may be."""

import pytest

from spiraltrunk import strategies
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.objects.spec import EXTENTS, MASSES
from spiraltrunk.workflows.grasp.world import draw_scene


@pytest.mark.parametrize(
    ("spec", "strategy"),
    [
        ("cylinder:diameter_mm=60,height_mm=950,mass_g=300", "wrap-vertical"),
        ("box:x_mm=28,y_mm=28,z_mm=28,mass_g=1", "tip-grip"),
        ("cylinder:diameter_mm=20,height_mm=5.2,mass_g=20", "tip-grip"),
        ("cylinder:diameter_mm=100,height_mm=200,mass_g=19900", "wrap-oblique"),
    ],
)
def test_objects_near_a_limit_are_drawn_within_it(spec: str, strategy: str) -> None:
    shape, limits = parse_object(spec), set()
    for seed in range(40):
        drawn = draw_scene(shape, seed, strategy=strategies.get(strategy)).shape
        assert all(EXTENTS.holds(extent) for extent in drawn.size)
        assert MASSES.holds(drawn.mass)
        limits |= {drawn.size, drawn.mass}
    assert len(limits) > 40  # Others are drawn as ever.


def test_others_are_drawn_with_the_whole_spread() -> None:
    shape = parse_object("cube-28")
    factors = [draw_scene(shape, seed, strategy=strategies.get("tip-grip")).shape.size[0] / 0.028 for seed in range(60)]
    assert 0.90 <= min(factors) < 0.91
    assert 1.09 < max(factors) <= 1.10
