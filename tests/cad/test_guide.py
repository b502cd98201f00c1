"""The guide can be followed: no step needs what a later one makes, and it uses up what the bill lists."""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from spiraltrunk.cad.checks.assembly import list_bolts
from spiraltrunk.cad.components.options import Motor
from spiraltrunk.cad.components.print_settings import find_settings
from spiraltrunk.cad.geometry.csg import compute_volume, contains, polar
from spiraltrunk.cad.housing.housing import find_bracket
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.test_stand import N_WEDGE, list_wedge_bolts
from spiraltrunk.cad.housing.winder import find_drum, motor_angles, motor_ring
from spiraltrunk.cad.output.bill_of_materials import build_bill, format_markdown
from spiraltrunk.cad.output.cable_lengths import KNOT, cable_length, cable_to_hold
from spiraltrunk.cad.output.catalogue import GROUPS, build_parts
from spiraltrunk.cad.output.electronics import list_electronics, main_fuse, supply_current
from spiraltrunk.cad.output.enclosure import BESIDE, BESIDE_SERVO, GAP, POWER, SUPPLY, size_enclosure
from spiraltrunk.cad.output.filament import SPARE, SPOOL
from spiraltrunk.cad.output.guide.assembly_guide import format_guide, list_steps
from spiraltrunk.cad.output.guide.step import Build
from spiraltrunk.cad.output.payload import compute_payload
from spiraltrunk.cad.output.top_view import find_port, find_servo, format_top_view
from spiraltrunk.cad.trunk.gripper import LUG_ARC, add_socket, find_seat
from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError

DESIGNS = {name: presets.get(name) for name in presets.NAMES}
DESIGNS["bare"] = replace(presets.PAPER, gripper=None, name="bare")


@cache
def find_volume(form):
    """Volume of a form, which many builds share [mm^3]."""
    return compute_volume(form)


def build(design, options, groups=("all",)):
    """The build of these groups, with volumes of definitions in place of solids."""
    parts = build_parts(design, groups, options)
    made = [
        SimpleNamespace(part=part, finding=SimpleNamespace(volume=find_volume(part.form), area=100.0)) for part in parts
    ]
    return Build(design, options, parts, build_bill(design, made, options))


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(name, marks=pytest.mark.slow) if name in {"paper-large-grip", "spirob-1m"} else name
        for name in DESIGNS
    ],
)
def built(request):
    from spiraltrunk.cad.components.options import MakeOptions

    return build(DESIGNS[request.param], MakeOptions())


def test_no_step_needs_what_a_later_one_makes(built):
    done = set()
    for step in list_steps(built):
        assert set(step.needs) <= done, step.title
        assert not done & set(step.makes), step.title
        done |= set(step.makes)


def test_all_that_is_made_is_needed_but_the_robot_itself(built):
    steps = list_steps(built)
    needed = {need for step in steps for need in step.needs}
    made = {thing for step in steps for thing in step.makes}
    assert made - needed == {"tilted flange", "robot with markers", "robot under tension"}


def test_each_purchase_is_taken_in_one_step(built):
    places = Counter(place for step in list_steps(built) for place in step.takes)
    assert set(places.values()) == {1}
    assert {row.place for row in built.bill.bought} <= set(places)
    text = format_guide(built.design, built.parts, built.bill, built.options)
    for row in built.bill.bought:
        assert str(row) in text


@pytest.mark.parametrize("group", GROUPS)
def test_each_purchase_for_one_group_is_taken_too(group, options):
    one = build(presets.PAPER, options, (group,))
    places = Counter(place for step in list_steps(one) for place in step.takes)
    assert {row.place for row in one.bill.bought} <= set(places)
    assert format_guide(one.design, one.parts, one.bill, options)


@pytest.mark.parametrize("group", ["trunk", "gripper", "shells", "moulds", "horn", "wedge", "markers"])
def test_a_group_needs_no_housing_that_fits(group, options):
    """A housing of this radius is refused; none of these groups is in it."""
    design = replace(presets.PAPER, housing=replace(presets.PAPER.housing, radius=0.06))
    with pytest.raises(DesignError, match="radius_mm is 60"):
        find_layout(design, options)
    one = build(design, options, (group,))
    assert format_guide(one.design, one.parts, one.bill, options)


def test_the_gripper_alone_needs_no_bed_for_the_trunk(options):
    small = replace(options, bed=(80.0, 80.0, 80.0))
    one = build(presets.PAPER, small, ("gripper",))
    guide = format_guide(one.design, one.parts, one.bill, small)
    assert "Clear the gripper's fingers" in guide
    assert "row of cable holes" not in guide


@pytest.mark.parametrize("tall", [256.0, 120.0])
def test_the_pins_of_all_cuts_are_pushed_in(tall, options):
    one = build(presets.PAPER, replace(options, bed=(256.0, 256.0, tall)), ("trunk",))
    pins = [row for row in one.bill.bought if row.item.startswith("dowel")]
    guide = format_guide(one.design, one.parts, one.bill, one.options)
    assert len(pins) == one.n_piece - 1
    assert f"Push the {sum(row.count for row in pins)} pins" in guide
    assert "open its hole with a drill 3 mm by hand" in guide


def test_a_cut_without_room_has_no_pins_to_push_in(options):
    one = build(presets.PAPER, options, ("trunk",))
    bare = replace(one.bill, bought=tuple(row for row in one.bill.bought if not row.item.startswith("dowel")))
    guide = format_guide(one.design, one.parts, bare, one.options)
    assert "Join the pieces of the trunk" in guide
    assert not re.search(r"Push the \d+ pins", guide)


def with_cables(n):
    """The paper's trunk with so many cables, and with a housing that takes their motors."""
    cable = replace(presets.PAPER.cable, angles=tuple(2 * math.pi * k / n for k in range(n)))
    return replace(presets.PAPER, cable=cable, housing=replace(presets.PAPER.housing, radius=0.2))


@pytest.mark.parametrize(
    ("n", "told"), [(4, "for the ids 1 to 4, two"), (6, "1 to 4 and 0x2FE for the ids 5 to 7, two")]
)
def test_the_guide_names_the_frames_of_all_motors(n, told, options):
    one = build(with_cables(n), options, ("drums",))
    assert told in format_guide(one.design, one.parts, one.bill, options)


@pytest.mark.parametrize(("n", "is_larger"), [(3, False), (6, True)])
def test_a_supply_of_more_power_than_the_enclosure_counts_is_told(n, is_larger, options):
    rows = {row.item: row for row in list_electronics(with_cables(n), options)}
    power = 24 * supply_current(with_cables(n), options)
    assert (power > POWER) == is_larger
    note = rows["enclosure with lid and knock-outs, vented"].note
    assert (f"the supply of {power:.0f} W is larger" in note) == is_larger


def test_more_motors_than_ids_are_refused(options):
    with pytest.raises(DesignError, match="part housing is for 8 cables; allowed: at most 7"):
        build_parts(with_cables(8), ("housing",), options)
    assert build_parts(with_cables(8), ("trunk",), options)
    assert build_parts(with_cables(7), ("housing",), options)


def test_a_current_above_all_fuses_is_refused(options):
    strong = replace(options, motor=Motor(current=13.0))
    with pytest.raises(DesignError, match=r"motor.current is 13 A; allowed: at most 12.1 A, for a blade fuse of 40 A"):
        main_fuse(presets.PAPER, strong)


def test_the_filament_is_the_parts_volumes_at_their_settings(built):
    """Area 100 mm^2 each, as `build` says: walls of lines times nozzle, the rest at the infill."""
    masses, solid = Counter(), Counter()
    for part in built.parts:
        if part.material.is_cast:
            continue
        settings, volume = find_settings(part.name), find_volume(part.form)
        wall = min(volume, settings.lines * built.options.nozzle * 100.0)
        share = (wall + settings.infill * (volume - wall)) / volume
        masses[part.material.name] += part.count * 1e-6 * part.material.density * volume * share
        solid[part.material.name] += part.count * 1e-6 * part.material.density * volume
    rows = {row.material: row for row in built.bill.bought if row.kind == "filament"}
    assert set(rows) == set(masses)
    for name, row in rows.items():
        assert float(row.note.split(" g in the parts")[0]) == pytest.approx(masses[name], abs=0.51)
        assert 0.1 * solid[name] < masses[name] < solid[name]
        assert (row.count - 1) * SPOOL < (1 + SPARE) * masses[name] <= row.count * SPOOL


def test_the_enclosure_holds_its_electronics_and_has_a_gland_a_lead(built):
    has_servo = built.design.gripper is not None
    inner = size_enclosure(has_servo=has_servo)
    items = [SUPPLY, *BESIDE.values(), *(BESIDE_SERVO.values() if has_servo else ())]
    assert inner.height > max(item[2] for item in items)
    assert sum((x + GAP) * (y + GAP) for x, y, _ in items) < inner.length * inner.width
    rows = {row.item: row for row in built.bill.bought if row.kind == "electronics"}
    assert (
        f"{inner.length:.0f} x {inner.width:.0f} x {inner.height:.0f} mm"
        in rows["enclosure with lid and knock-outs, vented"].size
    )
    assert rows["cable gland with nut"].count == built.design.n_cable + 4 + 2 * has_servo


def test_as_many_screws_as_holes(built):
    """By what they join, from the screws that the assembly check places in the solids."""
    bolts = list_bolts(built.design, built.options, {part.name for part in built.parts})
    wedge = list_wedge_bolts(built.options)
    wanted = Counter(bolt.what for bolt in bolts)
    wanted["wedge to flange or bench"] = 4
    wanted["adapter or wedge onto wedge"] = N_WEDGE * sum(bolt.nut_at is not None for bolt in wedge)
    wanted["drum to rotor"] = 4 * built.design.n_cable
    bought, nuts = Counter(), Counter()
    for row in built.bill.bought:
        bought[row.place] += row.count * ("screw" in row.item)
        nuts[row.place] += row.count * (row.item.startswith("nut"))
    assert +bought == wanted
    with_nuts = {bolt.what for bolt in (*bolts, *wedge) if bolt.nut_at is not None}
    assert +nuts == Counter({what: wanted[what] for what in with_nuts})


def test_counts_are_the_designs(built):
    n = built.design.n_cable
    counts = Counter()
    for row in built.bill.bought:
        counts[row.item] += row.count
    assert counts["motor RoboMaster GM6020"] == counts["cable"] == counts["crimp bead"] == n
    assert counts["reflective marker"] == 3 * built.design.n_section
    assert counts["servo DS-929MG"] == (built.design.gripper is not None)
    gripper = built.design.gripper
    assert counts["strand"] == (0 if gripper is None else 2 * gripper.n_finger * gripper.n_leg)
    inserts = [row.count for row in built.bill.bought if row.item == "heat-set insert"]
    layout = find_layout(built.design, built.options)
    assert sorted(inserts) == sorted([len(layout.bases), len(layout.posts)])


def test_each_step_says_what_to_do_and_how_to_check(built):
    steps = list_steps(built)
    assert len({step.title for step in steps}) == len(steps)
    for step in steps:
        assert step.work
        assert step.check
        assert step.makes
    servo = any("ervo" in step.title for step in steps)
    assert servo == (built.design.gripper is not None)


def test_the_head_says_that_nothing_was_built(built):
    text = format_guide(built.design, built.parts, built.bill, built.options)
    assert "Nothing was built from this guide yet" in text.split("##", maxsplit=1)[0]
    for part in built.parts:
        if not part.material.is_cast:
            settings = find_settings(part.name)
            assert settings.lines >= 2
            assert 0 < settings.infill <= 1
    numbers = [int(number) for number in re.findall(r"^### (\d+)\.", text, re.MULTILINE)]
    assert numbers == list(range(1, len(numbers) + 1))
    for title, number in re.findall(r"- Needs: .*?([a-z ]+) \(step (\d+)\)", text):
        assert f"Makes: {title.strip()}" in text or int(number) > 0


def test_the_tables_have_as_many_cells_as_columns(built):
    for line in format_markdown(built.design, built.bill).splitlines():
        if line.startswith("|"):
            assert line.count("|") in (4, 7)


@pytest.mark.parametrize("name", ["PLA", "PETG", "ASA"])
def test_the_rigid_material_is_chosen_in_the_design(name, options):
    design = replace(presets.PAPER, housing=replace(presets.PAPER.housing, material=name))
    one = build(design, options)
    materials = {part.group: part.material.name for part in one.parts}
    assert {materials[group] for group in ("housing", "drums", "horn", "adapter", "wedge", "markers", "moulds")} == {
        name
    }
    assert materials["trunk"] == materials["gripper"] == "TPU 95A"
    assert f"Rigid parts are of {name}." in format_guide(design, one.parts, one.bill, options)


NOUNS = (
    "calliper", "drill", "hex key", "spanner", "jaws", "scissors", "pliers", "soldering iron", "luggage scale", "pen",
    "cold metal plate", "bench supply", "Linux", "tweezers", "masking tape", "electrical tape", "sewing thread",
    "gauge", "steel wire", "multimeter", "screwdriver", "glasses", "gloves", "rubber band", "straight edge",
    "blocks of", "cups", "spirit level", "flush cutter", "pin vice", "second person", "vacuum chamber", "dish soap",
    "cyanoacrylate glue",
)  # fmt: skip
"""What a reader takes for a tool, whatever size or purpose follows."""


def test_each_tool_of_a_sentence_is_in_its_steps_list_and_in_the_guides(built):
    text = format_guide(built.design, built.parts, built.bill, built.options)
    listed = set(text.split("## Tools")[1].split("## Steps")[0].strip().removeprefix("- ").split("\n- "))
    used = set()
    for step in list_steps(built):
        said = " ".join((*step.work, step.check))
        taken = {str(row) for row in built.bill.bought if row.place in step.takes}
        for noun in NOUNS:
            if re.search(rf"(?i)\b{noun}", said):
                is_known = any(noun.lower() in own.lower() for own in {*step.tools, *taken})
                assert is_known or (noun == "drill" and "A drill is too short" in said), (step.title, noun)
        for tool in step.tools:
            assert tool in said, (step.title, tool)
        used |= set(step.tools)
    assert used == listed
    assert {noun for noun in NOUNS if any(noun.lower() in tool.lower() for tool in used)} >= {
        "calliper", "hex key", "jaws", "luggage scale", "bench supply", "steel wire"
    }  # fmt: skip


def test_the_order_of_what_cannot_be_done_later(built):
    """Pull wires lie in the neck before the lid closes it; the flange is ready before wedges; payload before power."""
    at = {step.title: k for k, step in enumerate(list_steps(built))}
    said = {step.title: " ".join(step.work) for step in list_steps(built)}
    wired = next(title for title in at if "Pull wires" in said[title])
    assert at[wired] < at["Neck onto the lid"] < at["Thread the trunk and shut the lid"]
    assert at["Prepare the arm's flange"] < at["Only to measure at a tilt: the wedges"]
    assert at["Knots at the tip"] < at["Tell the arm its payload"] < at["First pull"]
    out = [title for title, text in said.items() if "pull the strips of tape out" in text]
    assert out == ["First pull"]
    assert "never tried on a motor" in said["First pull"]


def test_lengths_add_up(built):
    """The pieces and the gripper's plate are the trunk's length."""
    head = format_guide(built.design, built.parts, built.bill, built.options).split("## Print")[0]
    if built.has_gripper:
        found = re.search(r"(\d+) mm long from .*?(?:together|piece) (\d+) mm, .*?gripper, ([\d.]+) mm;", head)
        total, pieces, plate = (float(number) for number in found.groups())
        assert pieces + plate == pytest.approx(total, abs=1.05)
    assert f"{2 * built.drum.radius:.1f} mm to the cable's middle" in format_markdown(built.design, built.bill)


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
def test_the_payload_is_the_simulations(design):
    """Mass, centre and moments of the straight robot in MuJoCo, less the gripper."""
    import mujoco

    from spiraltrunk.sim.robot.trunk import trunk_spec

    model = trunk_spec(replace(design, gripper=None)).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    body = model.body("housing").id
    load = compute_payload(design)
    assert load.mass == pytest.approx(model.body_subtreemass[body], rel=1e-9)
    assert data.subtree_com[body] == pytest.approx([0.0, 0.0, load.center], abs=1e-9)
    about = np.zeros((3, 3))
    for k in range(body, model.nbody):
        turn, apart = data.ximat[k].reshape(3, 3), data.xipos[k] - data.subtree_com[body]
        about += turn @ np.diag(model.body_inertia[k]) @ turn.T
        about += model.body_mass[k] * (apart @ apart * np.eye(3) - np.outer(apart, apart))
    assert np.diag(about) == pytest.approx([load.transverse, load.transverse, load.axial], rel=1e-6)


def test_the_top_view_shows_the_openings_where_the_parts_have_them(built):
    from xml.etree import ElementTree as ET

    parts = {part.name: part for part in built.parts}
    layout = find_layout(built.design, built.options)
    port = find_port(layout)
    middle = polar(layout.radius - built.options.rim / 2, port, built.options.plate + 8.0)
    solid = {angle: contains(parts["housing"].form, np.array([polar(layout.radius - 1.0, angle, middle[2])]))[0]
             for angle in (port, port + 0.3)}  # fmt: skip
    assert solid == {port: False, port + 0.3: True}
    if built.has_gripper:
        turn, away = find_bracket(built.design, layout, built.options)
        x, y, _ = polar(away, turn + math.pi / 2, 0.0)  # In the lid's frame; turned over about x: y to -y.
        assert math.atan2(-y, x) % (2 * math.pi) == pytest.approx(find_servo(built.design, built.options))
    root = ET.fromstring(format_top_view(built.design, built.options))
    words = [one.text for one in root.iter() if one.text and one.text.strip()]
    assert sum(word.startswith("motor ") for word in words) == built.design.n_cable


def test_the_dorsal_mark_is_told_from_a_post_where_cable_1_is_not_dorsal(options):
    cable = replace(presets.PAPER.cable, angles=tuple(math.radians(angle) for angle in (59, 179, 299)))
    texts = {
        design: next(s.work[0] for s in list_steps(build(design, options)) if s.title == "Motors into the housing")
        for design in (presets.PAPER, replace(presets.PAPER, cable=cable))
    }
    straight, turned = texts.values()
    assert "over one of the posts: the one from which the opening for the wires lies 131 deg anticlockwise" in straight
    assert "179 deg clockwise, seen from above, from the post just past which the opening for the wires lies" in turned
    assert "motor 1 at 119 deg, motor 2 at 239 deg and motor 3 at 359 deg" in turned


def test_words_of_the_top_view_lie_on_no_line_of_their_own(built):
    from xml.etree import ElementTree as ET

    def is_clear(word: ET.Element, center: tuple[float, float], radius: float) -> bool:
        wide, x, y = 5.5 * len(word.text), float(word.get("x")), float(word.get("y")) - 7.0
        near = [max(abs(x - center[0]) - wide, 0.0), max(abs(y - center[1]) - 8.0, 0.0)]
        return math.hypot(*near) > radius

    root = ET.fromstring(format_top_view(built.design, built.options))
    tag = "{http://www.w3.org/2000/svg}"
    words = {one.text: one for one in root.iter(f"{tag}text")}
    around = 4.0 * find_layout(built.design, built.options).radius
    left = float(root.get("viewBox").split()[0])
    for name in {"dorsal", "wires", "servo (lid)"} & set(words):
        assert is_clear(words[name], (0.0, 0.0), around), name
        assert abs(float(words[name].get("x"))) + 5.5 * len(name) < -left, name
    guides = [one for one in root.iter(f"{tag}circle") if float(one.get("r")) == 12.0]
    assert len(guides) == built.design.n_cable
    for k, guide in enumerate(guides):
        assert is_clear(words[f"guide {k + 1}"], (float(guide.get("cx")), float(guide.get("cy"))), 14.0)


def test_all_that_the_steps_use_of_cables_is_bought(built):
    """Holes, knots and currents are tried on a cable that is not cut to its length for the robot."""
    rows = {row.item: row for row in built.bill.bought}
    long = float(rows["cable for trials"].size.split()[2])
    assert long >= float(rows["cable"].size.split()[2]) + 2 * 300.0
    text = " ".join(sentence for step in list_steps(built) for sentence in (*step.work, step.check))
    assert text.count("cable for trials") == 4
    assert not re.search("test cable|rest of a cable|spare cable", text)


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
def test_anticlockwise_winds_a_cable_in_that_runs_outside(design, options):
    """The cable meets its drum tangentially, away from the axis, where the drum moves on along the cable."""
    drum, ring = find_drum(design, options), motor_ring(design, options)
    hole = 1e3 * float(design.hole_position[0, 0, 1])
    for angle, axis in zip(design.cable.angles, motor_angles(design), strict=True):
        guide = np.array(polar(hole, angle, 0.0)[:2])
        center = np.array(polar(ring, axis, 0.0)[:2])
        apart = center - guide
        spread = math.asin(drum.radius / math.hypot(*apart))
        bearing = math.atan2(apart[1], apart[0])
        way = math.sqrt(apart @ apart - drum.radius**2)
        touches = [guide + way * np.array([math.cos(bearing + s), math.sin(bearing + s)]) for s in (spread, -spread)]
        outer = max(touches, key=lambda point: math.hypot(*point))
        arm = outer - center
        assert arm @ (outer - guide) == pytest.approx(0.0, abs=1e-9)
        moves = np.array([-arm[1], arm[0]])  # Anticlockwise, seen from the trunk.
        assert moves @ (outer - guide) > 0


def test_the_gripper_locks_anticlockwise(options):
    """Lugs are at 0 and 180 deg from finger 1: entered a quarter turn clockwise of it, they pass below the lip."""
    seat = find_seat(presets.PAPER, options)
    tools = add_socket(seat, 0.0)
    ring, level = (seat.inner + seat.outer) / 2, -seat.lip - seat.lug / 2

    def has_room(turn, z):
        edges = [turn + lug + side * LUG_ARC / 2 for lug in (0.0, math.pi) for side in (-1, 0, 1)]
        points = np.array([polar(ring, angle, z) for angle in edges])
        return np.any([contains(tool, points) for tool in tools], axis=0).all()

    entry = -math.pi / 2
    assert has_room(entry, -seat.lip / 2)
    assert all(has_room(turn, level) for turn in np.linspace(entry, 0.0, 10))
    assert not has_room(0.0, -seat.lip / 2)
    assert not has_room(entry - math.pi / 4, level)


def test_a_cable_reaches_from_drum_to_tip_with_the_lid_lifted(built):
    """What stands out at the tip is all that the turns, the way and the knot do not use."""
    design, options, drum = built.design, built.options, built.drum
    around = 2 * math.pi * drum.radius
    assert drum.turns_straight < drum.turns_in < drum.turns
    used = KNOT + drum.turns_straight * around
    straight = 1e3 * float(design.cable_in_section.sum() + design.straight_gap.sum())
    assert cable_length(design, options) - used - cable_to_hold(design) > straight
    on_drum = 2 * math.pi * drum.radius * (drum.turns - drum.turns_straight)
    assert cable_to_hold(design) == pytest.approx(KNOT + on_drum)
    assert cable_to_hold(design) > 2 * KNOT


def test_the_code_for_other_dimensions_runs(built, monkeypatch, tmp_path):
    """With the numbers that it shows it makes the same export again."""
    from spiraltrunk.design import write_design
    from spiraltrunk.workflows.export import export

    asked = []
    monkeypatch.setattr(export, "export_robot", lambda design, folder, request: asked.append((design, request)))
    monkeypatch.chdir(tmp_path)
    write_design(built.design, "trunk.toml")
    text = format_guide(built.design, built.parts, built.bill, built.options)
    exec(text.split("```python")[1].split("```")[0], {})
    assert asked[0][0] == built.design
    assert asked[0][1].options == built.options
