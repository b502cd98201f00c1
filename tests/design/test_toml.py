"""Design files: what is written reads back equal, and what is left out takes its default."""

import math
import tomllib
from dataclasses import fields, replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from spiraltrunk.design import (
    ArmDesign,
    CableDesign,
    GripperDesign,
    HousingDesign,
    JointDesign,
    MassDesign,
    Spiral,
    TrunkDesign,
    format_design,
    load_design,
    presets,
    write_design,
)
from spiraltrunk.design.materials import RIGID
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.rules import compactness
from spiraltrunk.design.schema import TABLES
from spiraltrunk.design.toml import parse_design
from spiraltrunk.errors import DesignError

MINIMAL = 'name = "small"\n[spiral]\na_mm = 26.0\nb = 0.16\n'
KEYS = [(table, key) for table, keys in TABLES.items() for key in keys]

in_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
"""The folder is shared by all examples of a test: each writes its file anew."""


def texts(most):
    return st.text(min_size=1, max_size=most).filter(str.isprintable)


def spread(least, most):
    """Numbers over many magnitudes, whole digits and all."""
    return st.floats(math.log(least), math.log(most)).map(math.exp) | st.floats(least, most)


GRIPPERS = st.builds(
    GripperDesign,
    n_finger=st.integers(2, 8),
    b=spread(1e-6, 1.9),
    delta_theta=spread(2e-4, 1.5),
    n_phalanx=st.integers(1, 8),
    finger_length=spread(2e-5, 9.0),
    finger_width=spread(2e-5, 9.0),
    mount_radius=st.just(0.0) | spread(1e-9, 9.0),
    mass=spread(1e-9, 9.0),
    stiffness=spread(1e-9, 9.0),
    tension_max=spread(2e-6, 9e3),
)
HOUSINGS = st.builds(
    HousingDesign, radius=spread(2e-3, 0.99), length=spread(2e-3, 0.99), material=st.sampled_from(list(RIGID)),
    mass=st.none() | spread(2e-6, 99.0), neck_mass=st.none() | spread(2e-6, 99.0),
)  # fmt: skip
ARMS = st.builds(
    ArmDesign,
    model=st.just("panda") | texts(200).map("/arms/{}".format),
    mount_site=texts(200),
    base_height=st.just(0.0) | spread(1e-9, 9.0),
    roll=st.floats(-9.9, 9.9),
    home=st.none() | st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=32).map(tuple),
)


@st.composite
def cables(draw):
    count = draw(st.integers(2, 12))
    start, turn = draw(st.floats(-90.0, 90.0)), 2 * math.pi / count
    return CableDesign(
        angles=tuple(start + i * turn + draw(st.floats(-0.1, 0.1)) for i in range(count)),
        hole_fraction=draw(st.floats(0.01, 0.99)),
        tension_max=draw(spread(2e-3, 9e3)),
        friction=draw(st.just(0.0) | spread(1e-9, 1.9)),
    )


@st.composite
def designs(draw):
    b, n_section = draw(st.floats(0.02, 0.5)), draw(st.integers(2, 40))
    stiffness = st.lists(spread(2e-12, 9e5), min_size=n_section - 1, max_size=n_section - 1).map(tuple)
    masses = st.lists(spread(2e-12, 9e2), min_size=n_section, max_size=n_section).map(tuple)
    try:
        return TrunkDesign(
            name=draw(texts(200)),
            spiral=Spiral(a=draw(spread(1e-2, 10.0)), b=b),
            k=compactness(b) * draw(st.floats(0.95, 1.05)),
            delta_theta=draw(st.floats(0.1, 1.2)),
            n_section=n_section,
            theta_tip=draw(st.floats(-5.0, 5.0)),
            joint=JointDesign(
                radius=draw(spread(1.1e-5, 1e-4)),
                length=draw(spread(1.1e-5, 1e-4)),
                youngs_modulus=draw(spread(2e3, 9e11)),
                damping_time=draw(st.just(0.0) | spread(1e-9, 9.0)),
                stiffness=draw(st.none() | stiffness),
            ),
            cable=draw(cables()),
            mass=MassDesign(
                density=draw(spread(0.2, 2.9e4)),
                sections=draw(st.none() | masses),
                center_fraction=draw(st.none() | st.floats(1e-9, 0.99)),
            ),
            gripper=draw(st.none() | GRIPPERS),
            housing=draw(HOUSINGS),
            arm=draw(ARMS),
        )
    except DesignError:
        assume(False)
        raise


def dotted(table, name):
    return f"{table}.{name}" if table else name


# Round trip.


@in_folder
@given(designs())
def test_a_design_written_and_read_back_is_equal(tmp_path, design):
    assert load_design(write_design(design, tmp_path / "trunk.toml")) == design


@pytest.mark.parametrize("name", presets.NAMES)
def test_presets_are_found_by_name_and_survive_a_file(tmp_path, name):
    design = load_design(name)
    assert design is presets.get(name)
    path = write_design(design, str(tmp_path / "trunk.toml"))
    assert path == tmp_path / "trunk.toml"
    assert load_design(str(path)) == design


def test_every_field_has_its_key(full):
    """No field of any part can be forgotten in the file, and no key names a field that is not there."""
    parts = {field.name: type(getattr(PAPER, field.name)) for field in fields(TrunkDesign)}
    tables = {table: parts[table] for table in TABLES if table}
    for owner in (TrunkDesign, *tables.values()):
        own = [key.field for _, key in KEYS if key.owner is owner]
        expected = [field.name for field in fields(owner) if field.name not in tables]
        assert sorted(own) == sorted(expected if owner is TrunkDesign else [field.name for field in fields(owner)])
    written = tomllib.loads(format_design(full))
    assert all(key.name in (written[table] if table else written) for table, key in KEYS)


def test_every_key_with_a_dimension_wears_its_unit():
    units = {"mm", "deg", "mpa", "s", "nm_per_rad", "n", "kg_per_m3", "g", "kg"}
    bare = {
        "name",
        "b",
        "k",
        "n_section",
        "hole_fraction",
        "friction",
        "center_fraction",
        "n_finger",
        "n_phalanx",
        "n_leg",
        "model",
        "mount_site",
        "material",
    }
    for _, key in KEYS:
        assert (key.name == key.field) if key.field in bare else (key.name.removeprefix(f"{key.field}_") in units)


def test_the_file_reads_well():
    text = format_design(PAPER)
    assert text.startswith("# A spiraltrunk design")
    assert "`spiraltrunk design`" in text
    for line in ("schema = 1", 'name = "paper"', "delta_theta_deg = 30.0", "theta_tip_deg = 90.0",
                 "n_section = 18", "radius_mm = 3.825", "length_mm = 2.1", "youngs_modulus_mpa = 16.9",
                 "angles_deg = [0.0, 120.0, 240.0]",
                 "sections_g = [33.0, 26.0, 21.3, 20.4, 14.2, ", "base_height_mm = 800.0"):  # fmt: skip
        assert f"\n{line}" in text
    assert "a_mm = 26.1313153" in text


def test_hand_written_integers_read_like_floats(full, load_text, edit):
    text = edit("cable", "angles_deg", "[0, 120, 2.4e2]", edit("spiral", "delta_theta_deg", "3_0"))
    assert load_text(text) == full
    assert full.delta_theta == math.pi / 6


def test_a_byte_order_mark_is_no_part_of_the_text(load_text):
    assert load_text(b"\xef\xbb\xbf" + format_design(PAPER).encode()) == PAPER


# What may be left out.


def test_the_smallest_file_takes_every_default(load_text):
    spiral = Spiral(a=0.026, b=0.16)
    expected = TrunkDesign(name="small", spiral=spiral, k=compactness(0.16), gripper=None)
    assert load_text(MINIMAL) == expected
    assert load_text("schema = 1\n" + MINIMAL) == expected


def test_the_gripper_is_there_only_with_its_table(load_text):
    assert load_text(MINIMAL).gripper is None
    assert load_text(MINIMAL + "[gripper]\n").gripper == GripperDesign()
    assert load_text(MINIMAL + "[gripper]\nn_finger = 2\n").gripper == GripperDesign(n_finger=2)


@pytest.mark.parametrize(("table", "key"), KEYS)
def test_a_key_left_out_takes_its_default_or_is_asked_for(load_text, edit, refusal, table, key):
    text = edit(table, key.name, None)
    assert text != edit(table, "", None)
    if key.is_required:
        error = refusal(text)
        assert (error.name, error.got) == (dotted(table, key.name), "missing")
        return
    design = load_text(text)
    owner = design if key.owner is TrunkDesign else getattr(design, table)
    default = next(field.default for field in fields(key.owner) if field.name == key.field)
    assert getattr(owner, key.field) == (compactness(design.spiral.b) if key.field == "k" else default)


def test_only_what_has_no_default_is_required():
    required = [dotted(table, key.name) for table, key in KEYS if key.is_required]
    assert required == ["name", "spiral.a_mm", "spiral.b", "joint.radius_mm", "joint.length_mm", "cable.angles_deg"]


# The arm's model.


@pytest.mark.parametrize("model", ["arm.xml", "arms/ur5.xml", "../arm.xml", "./panda"])
def test_a_relative_model_starts_at_the_files_folder(tmp_path, monkeypatch, model):
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    text = MINIMAL + f'[arm]\nmodel = "{model}"\n'
    Path("robots/trunk.toml").write_text(text)
    for path in (Path("robots/trunk.toml"), tmp_path / "robots" / "trunk.toml"):
        assert load_design(path).arm.model == str(tmp_path / "robots" / model)


@pytest.mark.parametrize("model", ["panda", "fr3", "another-arm_7", "/arms/ur5.xml"])
def test_a_name_or_absolute_model_stays(load_text, model):
    assert load_text(MINIMAL + f'[arm]\nmodel = "{model}"\n').arm.model == model


def test_a_relative_model_is_written_as_it_is():
    design = replace(PAPER, arm=ArmDesign(model="arms/ur5.xml"))
    assert tomllib.loads(format_design(design))["arm"]["model"] == "arms/ur5.xml"


def test_a_model_too_long_once_resolved_is_refused(refusal):
    assert refusal(MINIMAL + f'[arm]\nmodel = "{"x" * 999}"\n').name == "arm.model"


def test_one_number_enlarges_the_gripper(tmp_path):
    path = tmp_path / "trunk.toml"
    path.write_text('name = "large"\n[spiral]\na_mm = 26.0\nb = 0.16\n[gripper]\nscale = 1.5\n')
    design = load_design(path)
    assert design.gripper == GripperDesign().enlarged(1.5)
    assert load_design(write_design(design, path)) == design


def test_the_scale_applies_to_the_sizes_beside_it(tmp_path):
    path = tmp_path / "trunk.toml"
    path.write_text('name = "long"\n[spiral]\na_mm = 26.0\nb = 0.16\n[gripper]\nfinger_length_mm = 50.0\nscale = 2\n')
    assert load_design(path).gripper.finger_length == pytest.approx(0.100)


@pytest.mark.parametrize(("scale", "message"), [
    ("2.5", r"gripper\.scale is 2\.5; allowed: a finite number, at least 1, at most 2"),
    ("0.5", r"gripper\.scale is 0\.5; allowed: a finite number, at least 1, at most 2"),
    ("nan", r"gripper\.scale is nan; allowed: a finite number"),
    ("'large'", r"gripper\.scale is 'large'; allowed: a finite number"),
])  # fmt: skip
def test_scales_beyond_the_range_are_refused_by_key(tmp_path, scale, message):
    path = tmp_path / "trunk.toml"
    path.write_text(f'name = "bad"\n[spiral]\na_mm = 26.0\nb = 0.16\n[gripper]\nscale = {scale}\n')
    with pytest.raises(DesignError, match=message):
        load_design(path)


def test_the_file_of_the_paper_is_as_before():
    """Its digest identifies designs in the results of earlier versions; a new key may not change it."""
    assert "n_leg" not in format_design(PAPER)
    assert "n_leg = 2" in format_design(presets.get("paper-large-grip"))


def test_content_of_a_file_is_read_without_a_file():
    text = format_design(presets.PAPER).encode()
    assert parse_design(text, "page") == presets.PAPER
    with pytest.raises(DesignError, match=r"'page': joint\.radius_mm is 99"):
        parse_design(text.replace(b"radius_mm = 3.825", b"radius_mm = 99.0"), "page")
