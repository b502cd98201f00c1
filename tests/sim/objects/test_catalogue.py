"""Objects: their text form, their names, their bodies."""

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, SpiralTrunkError, UnknownName
from spiraltrunk.sim.objects.catalogue import CATALOGUE, DEFAULT_OBJECT, ObjectSpec, add_object, parse_object, scaled

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


TEXTS = r"(cylinder|sphere|box|cone|ring|bottle|stl|mjcf):([a-z_]{0,12}=[-+0-9.einfa]{0,9},?){0,4}"


@given(st.text(max_size=60) | st.from_regex(TEXTS))
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
        ("cylinder:diameter_mm=60,height_mm=240,mass_g=250,", "is empty, between or after commas; .*each measure once"),
        ("cylinder:diameter_mm=60,,height_mm=240,mass_g=250", "is empty, between or after commas; .*each measure once"),
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
        ("cone:diameter_mm=50,mass_g=50", "object is without height_mm; allowed: cone:diameter_mm=,height_mm=,mass_g="),
        ("ring:outer_mm=60,tube_mm=30,mass_g=40", "object.outer_mm is 60; allowed: more than twice the tube's 30"),
        ("ring:outer_mm=60,tube_mm=3,mass_g=40", "object.tube_mm is 3; allowed: a finite number, at least 5"),
        ("bottle:diameter_mm=60,height_mm=200,neck_mm=60,mass_g=40",
         "object.neck_mm is 60; allowed: less than the diameter's 60"),
        ("sphere:diameter_mm=50,mass_g=0.5", "object.mass_g is 0.5; allowed: a finite number, at least 1, below 20000"),
    ],
)  # fmt: skip
def test_impossible_measures_are_refused(text, match):
    with pytest.raises(DesignError, match=match):
        parse_object(text)


@pytest.mark.parametrize("text", ["teapot", "", "pyramid:x_mm=60", ":", "Cylinder-60"])
def test_unknown_names_list_the_known_ones(text):
    with pytest.raises(UnknownName, match="cylinder"):
        parse_object(text)


@pytest.mark.parametrize(
    ("kind", "size", "match"),
    [
        ("box", (0.1, 0.1), "2 numbers; allowed: 3 numbers"),
        ("box", [0.1, 0.1, 0.1], "a tuple of numbers"),
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


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_geom_is_of_the_body_object_and_every_name_its_own(name):
    spec = mujoco.MjSpec()
    add_object(spec, parse_object(name))
    model = spec.compile()
    names = [model.geom(g).name for g in range(model.ngeom)]
    assert names == ["object", *(f"object_{i}" for i in range(2, model.ngeom + 1))]
    assert {model.body(b).name for b in model.geom_bodyid} == {"object"}
    assert (model.geom_priority == 1).all()


NAMES = (
    "cylinder-33 cylinder-60 cylinder-60-heavy cylinder-90 cylinder-120 ball-80 ball-120 box-60 box-120 disc-80x20 "
    "ring-90 bottle-70 rod-10 bar-12x20 ball-30 cube-28 cylinder-32 cone-35"
)


ONE_EACH = {
    "cylinder-60", "ball-80", "box-60", "disc-80x20", "ring-90", "bottle-70", "rod-10", "bar-12x20", "cone-35",
}  # fmt: skip
"""One object of each kind."""


@pytest.mark.parametrize("name", NAMES.split())
def test_names_stay(name):
    assert name in CATALOGUE


@pytest.mark.parametrize(
    "name", [name if name in ONE_EACH else pytest.param(name, marks=pytest.mark.slow) for name in CATALOGUE]
)
@given(factor=st.floats(0.9, 1.1))
def test_a_scaled_object_keeps_its_mass_and_its_inertia_goes_with_the_square(name, factor):
    shape = parse_object(name)
    larger = scaled(shape, factor)
    assert larger.mass == shape.mass
    assert larger.friction == shape.friction
    np.testing.assert_allclose([larger.length, larger.width], factor * np.array([shape.length, shape.width]))
    np.testing.assert_allclose(larger.center(), factor * shape.center(), atol=1e-15)
    np.testing.assert_allclose(larger.inertia(), factor**2 * shape.inertia(), rtol=1e-9, atol=1e-15)


def test_the_default_is_in_the_catalogue():
    assert DEFAULT_OBJECT in CATALOGUE


def test_an_unknown_object_is_told_the_nearest_names_on_a_short_line():
    with pytest.raises(UnknownName, match=r"unknown object 'cylnder-60'; known: cylinder-60, ") as caught:
        parse_object("cylnder-60")
    assert len(str(caught.value)) < 250


def test_an_unknown_object_like_no_other_is_told_the_kinds_and_the_catalogue():
    with pytest.raises(UnknownName, match=r"unknown object 'can'; known: solids and files \(cylinder:, ") as caught:
        parse_object("can")
    assert str(caught.value).endswith("mjcf:, everyday:) and the catalogue, which spiraltrunk object lists")


@pytest.mark.parametrize(("more", "name"), [("mass_kg=0.35", "mass_kg"), ("foo=1", "foo"), (" Mass_g = 3", "Mass_g")])
def test_an_unknown_measure_is_told_with_the_known_ones(more, name):
    known = f"unknown measure of cylinder '{name}'; known: diameter_mm, height_mm, mass_g, pose"
    with pytest.raises(UnknownName, match=known):
        parse_object(f"cylinder:diameter_mm=60,height_mm=240,{more}")


def test_spaces_about_a_measure_do_not_matter():
    spaced = parse_object("cylinder: diameter_mm = 60 , height_mm= 240, mass_g =250")
    assert spaced == parse_object("cylinder:diameter_mm=60,height_mm=240,mass_g=250")


def test_a_catalogues_object_takes_a_pose():
    measures = CATALOGUE["bottle-70"]
    assert parse_object("bottle-70,pose=lying") == parse_object(f"{measures},pose=lying")
    assert parse_object("bottle-70,pose=lying").pose == "lying"
    with pytest.raises(DesignError, match="mass_g of 'bottle-70' is that of the catalogue; allowed: pose= "):
        parse_object("bottle-70,mass_g=3")


@pytest.mark.parametrize(
    ("name", "form"),
    [("mug.stl", "stl:path=mug.stl,mass_g=GRAMS"), ("./a b.OBJ", "obj:path=./a b.OBJ,mass_g=GRAMS"),
     ("cup.xml", "mjcf:path=cup.xml")],
)  # fmt: skip
def test_the_bare_name_of_a_file_is_told_how_a_file_is_given(name, form):
    with pytest.raises(DesignError) as caught:
        parse_object(name)
    assert str(caught.value) == f"object is {name!r}; allowed: {form}, which reads the file"
