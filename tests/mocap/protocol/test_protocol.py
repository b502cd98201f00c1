"""The packaged protocol is the paper's, its plan makes up for slack as the paper says, other files are told apart."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import SpiralTrunkError, TakeError
from spiraltrunk.mocap.protocol.checklist import format_checklist, format_schedule
from spiraltrunk.mocap.protocol.protocol import Protocol, Run, sort_takes
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.protocol.toml import load_protocol, parse_protocol, read_packaged
from spiraltrunk.model import reference


def test_the_packaged_protocol_is_the_papers():
    protocol = load_protocol("paper")
    bend = protocol.run("bend-dorsal")
    assert (bend.steps, bend.step, bend.n_shape, bend.takes, bend.theta_0) == (26, 0.005, 27, 2, math.pi / 2)
    tilts = {90 - math.degrees(run.theta_0) for run in protocol.runs if run.kind == "rest"}
    np.testing.assert_allclose(sorted(tilts), [0, 45, 90, 135])
    assert protocol.axes is None
    assert protocol.run("twist").kind == "twist"
    assert parse_protocol(read_packaged().encode(), source="x") == protocol


def test_a_plan_pulls_what_the_papers_model_says():
    protocol = load_protocol("paper")
    plan = build_schedule(PAPER, protocol, protocol.run("bend-dorsal"))
    shape = reference.bend_dorsal(PAPER, 0.005 * np.arange(27), math.pi / 2)
    np.testing.assert_array_equal(plan.commanded, shape.cable_change)
    np.testing.assert_array_equal(np.isnan(plan.pull), np.broadcast_to([False, True, True], (27, 3)))
    twist = build_schedule(PAPER, protocol, protocol.run("twist"))
    np.testing.assert_allclose(twist.commanded[:, 0], twist.commanded[0, 0], atol=1e-5)
    np.testing.assert_allclose(np.diff(twist.commanded[:, 1]), 0.005, atol=1e-5)
    rest = build_schedule(PAPER, protocol, protocol.run("rest-045"))
    assert np.isnan(rest.pull).all()


@pytest.mark.parametrize(("n_cable", "ventral"), [(2, [1]), (3, [1, 2]), (4, [2]), (6, [2, 3, 4])])
def test_a_plan_pulls_the_cables_that_the_models_pull(n_cable, ventral):
    """A ventral pull leaves lateral cables free, as a dorsal one leaves all but the first."""
    angles = tuple(2 * math.pi * i / n_cable for i in range(n_cable))
    design = replace(PAPER, cable=replace(PAPER.cable, angles=angles))
    for kind, pulled in (("bend-ventral", ventral), ("bend-dorsal", [0])):
        run = Run(name="bend", kind=kind, steps=2, step=0.02)
        plan = build_schedule(design, Protocol(name="p", runs=(run,), slack=(0.0,) * n_cable), run)
        assert np.flatnonzero(plan.is_pulled).tolist() == pulled
    rest = Run(name="rest", kind="rest")
    assert not build_schedule(design, Protocol(name="p", runs=(rest,), slack=(0.0,) * n_cable), rest).is_pulled.any()


@pytest.mark.parametrize("n_cable", [2, 4, 6])
def test_only_the_papers_three_cables_can_be_planned_to_twist(n_cable):
    angles = tuple(2 * math.pi * i / n_cable for i in range(n_cable))
    design = replace(PAPER, cable=replace(PAPER.cable, angles=angles))
    run = Run(name="twist", kind="twist", steps=2, step=0.02, first=0.02)
    with pytest.raises(TakeError, match="allowed for twist: 0, 120 and 240 deg"):
        build_schedule(design, Protocol(name="p", runs=(run,), slack=(0.0,) * n_cable), run)


@given(st.lists(st.floats(0, 0.02), min_size=3, max_size=3))
def test_slack_is_made_up_for_evenly(slack):
    """dL'_i = dL_i + C i with C = L_slack / N: nothing at first, all of it at the last step."""
    protocol = replace(load_protocol("paper"), slack=tuple(slack))
    for name in ("bend-dorsal", "twist"):
        plan = build_schedule(PAPER, protocol, protocol.run(name))
        more = plan.commanded - plan.change
        steps = plan.run.steps
        np.testing.assert_allclose(more, np.arange(steps + 1)[:, None] * np.array(slack) / steps, atol=1e-12)


def test_a_plan_beyond_the_trunk_is_refused():
    run = Run(name="far", kind="bend-dorsal", steps=30, step=0.005)
    with pytest.raises(TakeError, match="run 'far' asks for what the design 'paper' cannot do"):
        build_schedule(PAPER, Protocol(name="p", runs=(run,)), run)
    with pytest.raises(TakeError, match="slack_mm of the protocol has 2 numbers; allowed: 3"):
        build_schedule(PAPER, Protocol(name="p", runs=(run,), slack=(0.001, 0.0)), run)


def test_no_slack_is_none_for_any_number_of_cables():
    run = Run(name="rest", kind="rest", steps=0)
    plan = build_schedule(presets.get("spirob-15"), Protocol(name="p", runs=(run,)), run)
    assert plan.slack == (0.0, 0.0)
    assert plan.commanded.shape == (1, 2)


def test_the_list_and_the_table_say_the_same_lengths():
    protocol = replace(load_protocol("paper"), slack=(0.0026, 0.0, 0.0))
    plans = [build_schedule(PAPER, protocol, run) for run in protocol.runs]
    rows = [row.split(",") for row in format_schedule(PAPER, plans).splitlines()]
    assert rows[0] == ["run", "shape", "theta0_deg", "cable_1_m", "cable_2_m", "cable_3_m"]
    assert len(rows) == 1 + 4 + 27 + 7
    assert ["rest-045", "1", "45", "", "", ""] in rows
    bend = [row for row in rows if row[0] == "bend-dorsal"]
    assert float(bend[-1][3]) == pytest.approx(plans[4].change[-1, 0] + 0.0026, abs=1e-6)
    text = format_checklist(PAPER, protocol, plans)
    for i, told in enumerate(plans[4].commanded):
        cells = " | ".join(f"{round(1e3 * value, 2) + 0.0:.2f}" for value in told)
        assert f"| {i + 1} | {5 * i} | {cells} |" in text
        np.testing.assert_allclose([float(cell) for cell in bend[i][3:]], told, atol=6e-7)
    assert text.count("- [ ] take") == 4 + 2 + 2
    assert "bend-dorsal_2.csv" in text


@pytest.mark.parametrize(("given_", "expected"), [
    (["bend-dorsal_1.csv", "x/BEND-DORSAL 2.csv"], {"bend-dorsal": ["bend-dorsal_1.csv", "x/BEND-DORSAL 2.csv"]}),
    (["twist=a=b.csv"], {"twist": ["a=b.csv"]}),
    (["a\\rest-000.csv"], {"rest-000": ["a\\rest-000.csv"]}),
])  # fmt: skip
def test_takes_find_their_run(given_, expected):
    assert sort_takes(load_protocol("paper"), given_) == expected


def test_takes_come_in_the_protocols_order_and_the_longest_name_wins():
    runs = (Run(name="rest", kind="rest"), Run(name="rest-2", kind="rest"))
    protocol = Protocol(name="p", runs=runs)
    assert sort_takes(protocol, ["rest-2.csv", "rest.csv"]) == {"rest": ["rest.csv"], "rest-2": ["rest-2.csv"]}


@pytest.mark.parametrize("given_", ["take.csv", "twister.csv", "twist=", "=a.csv", "no/run=a.csv"])
def test_a_take_of_no_run_is_refused(given_):
    with pytest.raises(TakeError, match="belongs to no run; allowed: RUN=FILE"):
        sort_takes(load_protocol("paper"), [given_])
    with pytest.raises(TakeError, match="given twice"):
        sort_takes(load_protocol("paper"), ["twist=a.csv", "twist=a.csv"])


RUN = 'name = "b"\n[[run]]\nname = "bend"\nkind = "bend-dorsal"\ntilt_deg = 0\nsteps = 4\nstep_mm = 5\n'

WRONG = {
    "no TOML": ("name =", "allowed: a protocol in TOML"),
    "no run": ('name = "a"', "there is no [[run]]"),
    "an unknown key": (RUN + "speed = 3\n", "run 'bend'.speed is 3; allowed: only the keys name, kind"),
    "an unknown kind": (RUN.replace("bend-dorsal", "kick"), "kind is 'kick'; allowed: rest, bend-dorsal"),
    "no steps": (RUN.replace("steps = 4", "steps = 0"), "steps is 0; allowed: 1 to 1000"),
    "too many steps": (RUN.replace("steps = 4", "steps = 100000"), "allowed: 1 to 1000"),
    "a step of nan": (RUN.replace("step_mm = 5", "step_mm = nan"), "allowed: a finite number"),
    "a step of text": (RUN.replace("step_mm = 5", 'step_mm = "5"'), "allowed: a finite number"),
    "a step beyond sense": (RUN.replace("step_mm = 5", "step_mm = 5000"), "step_mm is 5000.0"),
    "a step huge": (RUN.replace("step_mm = 5", "step_mm = 1" + "0" * 400), "allowed: a finite number"),
    "two angles": (RUN + "theta0_deg = 3\n", "tilt_deg, from hanging, or theta0_deg"),
    "no angle": (RUN.replace("tilt_deg = 0\n", ""), "missing or there twice"),
    "a rest with steps": (RUN.replace("bend-dorsal", "rest"), "none at rest"),
    "a twist without first": (RUN.replace("bend-dorsal", "twist"), "first_mm is 0.0"),
    "two of a name": (RUN + RUN[11:], "two runs are called 'bend'"),
    "a name with slashes": (RUN.replace('"bend"', '"../bend"'), "run's name is '../bend'"),
    "an alignment": ('alignment = "tip"\n' + RUN, "alignment is tip"),
    "an orientation": ('orientation = "up"\n' + RUN, "orientation is 'up'"),
    "a slack": ("slack_mm = [1, 2, -3]\n" + RUN, "slack is"),
    "a section": (RUN + '[sections]\nx = "a"\n', "sections.x is 'a'"),
    "section 0": (RUN + '[sections]\n0 = "a"\n', "sections.0 is 'a'; allowed: numbers of sections, 1 at the base"),
    "a section with zeros": (RUN + '[sections]\n1 = "a"\n01 = "b"\n', "sections.01 is 'b'; allowed: numbers of"),
    "a name of two sections": (RUN + '[sections]\n1 = "a"\n2 = "a"\n', "sections has the name 'a' 2 times"),
    "a still": (RUN + "[still]\nhold_s = -1\n", "still.hold_s is -1.0"),
    "a schema": ("schema = 2\n" + RUN, "schema is 2, not 1; allowed: a protocol in TOML"),
    "an end before the start": (RUN + "begin_s = 3\nend_s = 2\n", "after begin_s, 3"),
    "a period without begin": (RUN + "period_s = 3\n", "with begin_s"),
    "deep": ("x = " + "[" * 4000, "allowed: a protocol in TOML"),
    "a long key": ("a." * 5000 + "b = 1", "more than 250 dots; allowed: a protocol in TOML"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_no_session_can_do_is_refused(wrong):
    text, told = WRONG[wrong]
    with pytest.raises(TakeError) as caught:
        parse_protocol(text.encode(), source="p.toml")
    assert "'p.toml'" in str(caught.value)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("sections", "told"),
    [(((0, "a"),), "sections has 0 for 'a'"), (((1, "a"), (1, "b")), "sections has the number 1 2 times")],
)
def test_sections_are_numbered_from_1_and_once(sections, told):
    with pytest.raises(TakeError, match=told):
        replace(load_protocol("paper"), sections=sections)


@given(st.binary(max_size=60), st.integers(0, 3000))
def test_any_bytes_are_a_protocol_or_refused(noise, at):
    data = read_packaged().encode()
    told = ""
    try:
        found = parse_protocol(data[:at] + noise + data[at:], source="p.toml")
    except SpiralTrunkError as error:
        found, told = None, str(error)
    assert isinstance(found, Protocol) or "p.toml" in told


@pytest.mark.parametrize("key", ["name = ", "sections = ", "sections.1 = ", "run = ", "[[run]]\nname = "])
def test_a_number_that_is_too_long_to_be_printed_is_refused(key):
    with pytest.raises(TakeError, match="a number has too many digits"):
        parse_protocol(f"{key}0x{'f' * 4200}".encode(), source="a.toml")


def test_the_name_rest_is_for_runs_at_rest():
    assert Run(name="rest", kind="rest").name == "rest"
    with pytest.raises(TakeError, match="kind is 'bend-dorsal'; allowed: rest, as the run's name is"):
        Run(name="rest", kind="bend-dorsal", steps=3, step=0.02)


def test_a_design_lies_beside_the_protocol(tmp_path):
    (tmp_path / "mine.toml").write_text("x")
    (tmp_path / "p.toml").write_text('design = "mine.toml"\n' + RUN[11:])
    protocol = load_protocol(tmp_path / "p.toml")
    assert (protocol.design, protocol.name) == (str(tmp_path / "mine.toml"), "p")
    with pytest.raises(TakeError):
        load_protocol(tmp_path / "missing.toml")
