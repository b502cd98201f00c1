"""Parts that several tests look at, made once."""

from __future__ import annotations

from dataclasses import replace

import pytest

from spiraltrunk.cad.catalogue import build_parts
from spiraltrunk.cad.options import MakeOptions
from spiraltrunk.design import design_from_rules, presets


@pytest.fixture(scope="session")
def options() -> MakeOptions:
    return MakeOptions()


@pytest.fixture(scope="session")
def small():
    """A short trunk with a gripper, quick to make: nine sections of 30 deg."""
    design = design_from_rules(b=0.16, arm_radius=0.026, turns=0.75, name="small")
    return replace(design, gripper=presets.PAPER.gripper)


@pytest.fixture(scope="session")
def made(small, options):
    """Every part of the small robot, as solid and mesh."""
    pytest.importorskip("build123d", reason="solids need the extra cad")
    from spiraltrunk.cad.kernel import build_mesh, build_solid

    parts = {}
    for part in build_parts(small, ["all"], options):
        solid = build_solid(part.form)
        parts[part.name] = (part, solid, build_mesh(solid, options.tolerance))
    return parts
