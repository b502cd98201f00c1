"""Objects: their text form, their moments of inertia against numerical integrals, their bodies."""

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, SpiralTrunkError, UnknownName
from spiraltrunk.sim.objects import CATALOGUE, DEFAULT_OBJECT, ObjectSpec, add_object, parse_object

MM = st.floats(5.0, 900.0)
GRAMS = st.floats(1.0, 15000.0)


@given(MM, MM, GRAMS)
def test_a_cylinder_reads_back(diameter, height, mass):
    shape = parse_object(f"cylinder:diameter_mm={diameter!r},height_mm={height!r},mass_g={mass!r}")
    assert shape.kind == "cylinder"
    np.testing.assert_allclose(shape.size, [height / 1e3, diameter / 1e3, diameter / 1e3], rtol=1e-12)
    assert shape.mass == pytest.approx(mass / 1e3, rel=1e-12)
    assert shape.width == pytest.approx(diameter / 1e3, rel=1e-12)


@given(st.permutations(["x_mm=240", "y_mm=50", "z_mm=70", "mass_g=250"]), st.sampled_from([",", ", ", " ,"]))
def test_the_order_of_the_measures_and_spaces_do_not_matter(measures, comma):
    shape = parse_object("box:" + comma.join(measures))
    assert shape == parse_object("box:x_mm=240,y_mm=50,z_mm=70,mass_g=250")
    assert shape.size == (0.24, 0.05, 0.07)
    assert shape.width == 0.07


@given(st.text(max_size=60) | st.from_regex(r"(cylinder|sphere|box):([a-z_]{0,12}=[-+0-9.einfa]{0,9},?){0,4}"))
def test_any_text_is_an_object_or_one_line_of_error(text):
    try:
        shape = parse_object(text)
    except SpiralTrunkError as error:
        said, values = str(error), ()
    else:
        said, values = "", (shape.mass, *shape.size)
    assert "\n" not in said
    assert np.isfinite(values).all()


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("cylinder:diameter_mm=60,mass_g=250",
         "object is without height_mm; allowed: cylinder:diameter_mm=,height_mm=,mass_g="),
        ("cylinder:", "diameter_mm"),
        ("cylinder:diameter_mm=60,diameter_mm=60,height_mm=240,mass_g=250", "each measure once"),
        ("cylinder:diameter_mm=60,height_mm=240,mass_g=250,colour=1", "colour=1.*each measure once"),
        ("cylinder:diameter_mm,height_mm=240,mass_g=250", "each measure once"),
        ("cylinder:diameter_mm=wide,height_mm=240,mass_g=250",
         "object.diameter_mm is 'wide'; allowed: a finite number, at least 5"),
        ("cylinder:diameter_mm=nan,height_mm=240,mass_g=250", "object.diameter_mm"),
        ("cylinder:diameter_mm=inf,height_mm=240,mass_g=250", "object"),
        ("cylinder:diameter_mm=-60,height_mm=240,mass_g=250", "object.diameter_mm"),
        ("cylinder:diameter_mm=60,height_mm=240,mass_g=0", "object.mass_g"),
        ("cylinder:diameter_mm=6000,height_mm=240,mass_g=250",
         "object.diameter_mm is 6000; allowed: a finite number, at least 5, below 1000"),
        ("sphere:diameter_mm=2,mass_g=250",
         "object.diameter_mm is 2; allowed: a finite number, at least 5, below 1000"),
        ("sphere:diameter_mm=50,mass_g=0.5", "object.mass_g is 0.5; allowed: a finite number, at least 1, below 20000"),
    ],
)  # fmt: skip
def test_impossible_measures_are_refused(text, match):
    with pytest.raises(DesignError, match=match):
        parse_object(text)


@pytest.mark.parametrize("text", ["teapot", "", "cone:diameter_mm=60", ":", "Cylinder-60"])
def test_unknown_names_list_the_known_ones(text):
    with pytest.raises(UnknownName, match="cylinder"):
        parse_object(text)


@pytest.mark.parametrize(
    ("kind", "size", "match"),
    [
        ("box", (0.1, 0.1), "2 numbers; allowed: 3 numbers"),
        ("box", [0.1, 0.1, 0.1], "a tuple of numbers"),
        ("sphere", (0.1, 0.1, 0.2), "three equal extents for a sphere"),
        ("cylinder", (0.2, 0.1, 0.11), "width equal to height for a cylinder"),
    ],
)
def test_impossible_sizes_are_refused(kind, size, match):
    with pytest.raises(DesignError, match=match):
        ObjectSpec(kind=kind, size=size, mass=1.0)


@pytest.mark.parametrize("friction", [0.0, -1.0, math.nan, math.inf])
def test_impossible_friction_is_refused(friction):
    with pytest.raises(DesignError, match=r"object\.friction"):
        ObjectSpec(kind="sphere", size=(0.1, 0.1, 0.1), mass=1.0, friction=friction)


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_catalogue_builds_with_the_stated_mass_and_size(name):
    shape = parse_object(name)
    spec = mujoco.MjSpec()
    add_object(spec, shape)
    model = spec.compile()
    assert model.body("object").mass[0] == pytest.approx(shape.mass, rel=1e-12)
    assert model.nv == 6
    assert model.neq == 0
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    ends = [data.site(f"object_{side}").xpos for side in ("left", "right")]
    np.testing.assert_allclose(ends[1] - ends[0], [shape.size[0], 0, 0], atol=1e-12)


def test_the_default_is_in_the_catalogue():
    assert DEFAULT_OBJECT in CATALOGUE


def _inside(shape, points):
    x, y, z = (2 * points / np.array(shape.size)).T
    if shape.kind == "sphere":
        return x**2 + y**2 + z**2 <= 1
    return (y**2 + z**2 <= 1) if shape.kind == "cylinder" else np.full(len(points), True)


@pytest.mark.parametrize(("kind", "size"), [("sphere", (0.1, 0.1, 0.1)), ("cylinder", (0.24, 0.06, 0.06)),
                                        ("box", (0.24, 0.05, 0.09))])  # fmt: skip
def test_inertia_is_the_integral_over_the_solid(kind, size):
    shape = ObjectSpec(kind=kind, size=size, mass=0.3)
    axes = [extent * ((np.arange(100) + 0.5) / 100 - 0.5) for extent in size]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[_inside(shape, points)]
    x2, y2, z2 = (points**2).mean(axis=0)
    np.testing.assert_allclose(shape.inertia(), 0.3 * np.array([y2 + z2, x2 + z2, x2 + y2]), rtol=2e-3)


@pytest.mark.parametrize("name", CATALOGUE)
def test_the_collision_shape_has_the_objects_inertia(name):
    """MuJoCo's own integral of the geometry, at the density that gives the mass."""
    shape = parse_object(name)
    spec = mujoco.MjSpec()
    body = add_object(spec, shape)
    body.explicitinertial = False
    body.geoms[0].mass = shape.mass
    model = spec.compile()
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body("object").iquat)
    inertia = turn.reshape(3, 3) @ np.diag(model.body("object").inertia) @ turn.reshape(3, 3).T
    np.testing.assert_allclose(inertia, np.diag(shape.inertia()), rtol=1e-9, atol=1e-12)
