"""Robot files: every key is read, refused in one line where it cannot be, and none raises a limit."""

from __future__ import annotations

import math
import re
from dataclasses import fields, replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.setup.load_cell_setup import LoadCellSetup
from spiraltrunk.hardware.setup.robot_file import (
    EXAMPLE,
    TABLES,
    CableSetup,
    MotorSetup,
    RobotFile,
    load_robot_file,
    parse_robot_file,
)
from spiraltrunk.hardware.setup.robot_limits import (
    build_winders,
    choose_period,
    choose_stiffness,
    fit_watches,
    lower_limits,
)

WRONG = {
    "name": ["7", '""'],
    "bus": ['"can0"', '"virtual"', '"socketcan:"', '"board:"', '"board:socket://host:1"', '"sts:/dev/ttyUSB0"', "3"],
    "watchdog": ['"dog"', '"relay:"', '"relay"', '"relay:rfc2217://host"', "true"],
    "arm": ['"panda"', '"panda:"', '"ur5:host"', '"panda:a b"', '"franky:http://x"', "1"],
    "motors.family": ['"dynamixel"', "1"],
    "motors.ids": ["[1, 1, 3]", "[0, 1, 2]", "[1, 2, 8]", "[1.0, 2, 3]", "[true, 2, 3]", "[]", "1", "[-1, 2, 3]"],
    "motors.directions": ["[1, 1]", "[1, 1, 0]", "[1, 1, 2]", '"in"', "[1, 1, nan]"],
    "motors.model": ['"sts9999"', "12"],
    "motors.period_ms": ["0.5", "nan", "0", "60", "-2", "inf"],
    "motors.feedback_ms": ["0.5", "nan", "11", "-1", "inf"],
    "cables.tension_floor_n": ["0", "-1", "nan", "inf", "1000", '"x"'],
    "cables.tension_max_n": ["0", "-1", "nan", "inf", "60.1", "1e9", "0.1"],
    "cables.speed_max_mm_s": ["0", "-1", "nan", "inf", "1e5", "1e9"],
    "cables.stiffness_n_mm": ["0", "-20", "nan", "inf", "4.99", "200.1", '"x"'],
    "cables.slack_mm": ["[1, 2]", "[nan, 0, 0]", "[100, 0, 0]", "[-100, 0, 0]", "[inf, 0, 0]", "1"],
    "load_cells.port": ['""', '"socket://host:1"', "1"],
    "load_cells.cables": ["[1, 1, 2]", "[0, 1, 2]", "[1, 2, 4]", "[1, 2]", "[]", "[1.5, 2, 3]", "1"],
    "load_cells.offsets_n": ["[0, 0]", "[nan, 0, 0]", "[201, 0, 0]", "[-201, 0, 0]", "0"],
    "load_cells.scales": ["[1, 1]", "[0, 1, 1]", "[nan, 1, 1]", "[1001, 1, 1]", "1"],
    "servo.least_us": ["499", "nan", "2600"],
    "servo.most_us": ["2501", "nan", "900"],
    "servo.open_us": ["899", "2101", "nan"],
    "servo.slack_us": ["999", "2001", "nan"],
    "servo.closed_us": ["899", "2101", "nan", "1200"],
}
"""Values that each key refuses."""


def read(text: str) -> RobotFile:
    return parse_robot_file(text.encode(), source="robot.toml")


def change(key: str, value: str) -> str:
    """The example with another value."""
    table, _, name = key.rpartition(".")
    lines, at, done = [], "", False
    for line in EXAMPLE.splitlines():
        at = line[1 : line.index("]")] if line.startswith("[") else at
        if at == table and line.partition(" = ")[0] == name:
            lines.append(f"{name} = {value}")
            done = True
            continue
        lines.append(line)
        if line == f"[{table}]" and f"\n{name} = " not in EXAMPLE:
            lines.append(f"{name} = {value}")
            done = True
    assert done
    return "\n".join(lines)


def test_the_example_says_what_it_shows():
    file = read(EXAMPLE)
    assert file.motors == MotorSetup(family="gm6020", ids=(1, 2, 3), directions=(1, 1, -1))
    assert file.cables == CableSetup(tension_max=30.0, speed_max=0.1, slack=(0.002, 0.0015, 0.0015))
    assert (file.arm, file.watchdog, file.relay) == ("panda:192.168.1.2", "board", None)
    assert file.load_cells is not None
    settings = file.load_cells.build_settings(3)
    assert (settings.port, settings.cables, settings.n_cable) == ("/dev/ttyACM1", (0, 1, 2), 3)
    assert (settings.offsets, settings.scales) == ((0.4, -0.1, 0.0), (1.0, 1.0, -1.0))
    assert file.servo is not None
    assert file.servo.closed_us == 2000.0


def test_load_cells_have_no_offset_and_their_own_sense_unless_it_is_said():
    settings = LoadCellSetup(port="COM3", cables=(2,)).build_settings(3)
    assert (settings.cables, settings.offsets, settings.scales) == ((1,), (0.0,), (1.0,))


@pytest.mark.parametrize("port", ["/dev/ttyUSB0", "/dev/ttyUSB1"])
def test_load_cells_have_a_port_of_their_own(port):
    file = RobotFile(
        name="x", bus="sts:/dev/ttyUSB0", motors=MotorSetup(family="sts", ids=(1, 2, 3)), watchdog="relay:/dev/ttyUSB1"
    )
    with pytest.raises(DesignError, match=rf"load_cells\.port is '{port}'; allowed: a port of its own"):
        replace(file, load_cells=LoadCellSetup(port=port, cables=(1,)))


@pytest.mark.parametrize("missing", ["port", "cables"])
def test_load_cells_need_a_port_and_cables(missing):
    text = EXAMPLE.replace('port = "/dev/ttyACM1"' if missing == "port" else "cables = [1, 2, 3]", "# ")
    with pytest.raises(DesignError, match=rf"load_cells\.{missing} is missing"):
        read(text)


def test_every_key_has_values_that_are_refused():
    assert set(WRONG) == {f"{table}.{key.name}".lstrip(".") for table, keys in TABLES.items() for key in keys}


@pytest.mark.parametrize(("key", "value"), [(key, value) for key, values in WRONG.items() for value in values])
def test_a_wrong_value_is_one_line_that_says_what_is_allowed(key: str, value: str):
    with pytest.raises(DesignError, match="allowed") as caught:
        build_winders(presets.PAPER, read(change(key, value)))
    assert "\n" not in str(caught.value)
    assert key.partition(".")[0] in str(caught.value)


@pytest.mark.parametrize("key", ["name", "bus", "motors.family", "motors.ids"])
def test_a_missing_key_is_named(key: str):
    name = key.rpartition(".")[2]
    text = "\n".join(line for line in EXAMPLE.splitlines() if not line.startswith(f"{name} = "))
    with pytest.raises(DesignError, match=f"{key} is missing"):
        read(text)


@pytest.mark.parametrize("text", ["torque_max_nm = 3", "[limits]\nx = 1", "[motors.more]\nx = 1"])
def test_what_is_not_known_is_refused(text: str):
    with pytest.raises((DesignError, ValueError), match=r"allowed|declare|only"):
        read(EXAMPLE + text)


def test_a_file_that_is_none_is_one_line(tmp_path):
    for path, data in (("absent.toml", None), (".", None), ("long.toml", b"#" * 300_000), ("bad.toml", b"\xff = [")):
        place = tmp_path / path
        if data is not None:
            place.write_bytes(data)
        with pytest.raises(DesignError, match="allowed: a robot file") as caught:
            load_robot_file(place)
        assert "\n" not in str(caught.value)


def test_a_file_for_another_number_of_cables_is_refused():
    with pytest.raises(DesignError, match=r"motors\.ids is 2 ids; allowed: 3"):
        build_winders(
            presets.PAPER, RobotFile(name="x", bus="socketcan:can0", motors=MotorSetup(family="gm6020", ids=(1, 2)))
        )


def test_a_file_with_fewer_ids_than_its_other_arrays_have_numbers_names_the_ids():
    text = change("motors.ids", "[1, 2]").encode()
    with pytest.raises(DesignError, match=r"motors\.ids is 2 ids; allowed: 3, one for each cable of paper"):
        parse_robot_file(text, source="robot.toml", design=presets.PAPER)


def test_a_floor_above_half_of_the_largest_tension_is_named_as_the_file_has_it():
    with pytest.raises(DesignError, match=r"cables\.tension_floor_n is 31 N; allowed: up to 30 N, half of") as caught:
        build_winders(presets.PAPER, read(change("cables.tension_floor_n", "31")))
    assert "winder" not in str(caught.value)
    text = change("cables.tension_floor_n", "30").replace("tension_max_n = 30.0", "tension_max_n = 60.0")
    assert build_winders(presets.PAPER, read(text))[0].limits.tension_floor == 30.0


def test_a_period_of_servos_leaves_time_for_a_lost_answer():
    """At 27 ms the probe of homing had no sample, and the watch of exchanged feedback trips from 26 ms on."""
    file = 'name = "x"\nbus = "sts:/dev/ttyUSB0"\n[motors]\nfamily = "sts"\nids = [1, 2, 3]\nperiod_ms = '
    build_winders(presets.PAPER, read(file + "20"))
    for period_ms in ("21", "27", "28"):
        with pytest.raises(DesignError, match=rf"motors\.period_ms is {period_ms}; allowed: .* at most 20"):
            read(file + period_ms)


@pytest.mark.parametrize("period", [0.01, 0.051, 1e2])
def test_a_period_too_long_for_the_resonance_of_rotor_and_cable_is_refused(period: float):
    bus = "socketcan:can0"
    motors = MotorSetup(family="gm6020", ids=(1, 2, 3), period=period)
    told = re.escape(f"motors.period_ms is {1e3 * period:g} ms; allowed: at most 7 ms")
    with pytest.raises(DesignError, match=told) as caught:
        build_winders(presets.PAPER, RobotFile(name="x", bus=bus, motors=motors, watchdog="none"))
    assert "\n" not in str(caught.value)
    build_winders(presets.PAPER, RobotFile(name="x", bus=bus, motors=replace(motors, period=None), watchdog="none"))


def test_ports_belong_to_the_family():
    servos = MotorSetup(family="sts", ids=(1, 2, 3))
    file = RobotFile(name="x", bus="sts:/dev/ttyUSB0", motors=servos, watchdog="relay:/dev/ttyUSB1")
    assert (file.relay, choose_period(servos)) == ("/dev/ttyUSB1", servos.data_sheet.period)
    for wrong in ({"bus": "socketcan:can0"}, {"watchdog": "board"}):
        with pytest.raises(DesignError, match=r"(?i)sts"):
            replace(file, **wrong)


@pytest.mark.parametrize("bus", ["socketcan:can0", "gs_usb:0", "slcan:/dev/ttyACM0"])
def test_a_board_watches_no_adapter(bus):
    motors = MotorSetup(family="gm6020", ids=(1, 2, 3))
    with pytest.raises(DesignError, match=rf"watchdog is 'board'; allowed: relay:PORT or none with bus {bus}"):
        RobotFile(name="x", bus=bus, motors=motors, watchdog="board")
    with pytest.raises(DesignError, match="watchdog is 'board'"):
        replace(RobotFile(name="x", bus="board:/dev/ttyACM0", motors=motors, watchdog="board"), bus=bus)


@pytest.mark.parametrize(("model", "nominal"), [("sts3215-12v", 12.0), ("sts3215-7v4", 7.4)])
def test_the_supply_of_servos_is_watched_about_its_nominal_voltage(model, nominal):
    motors = MotorSetup(family="sts", ids=(1, 2, 3), model=model)
    limits = fit_watches(SafetyLimits(), CableSetup(), motors)
    assert (limits.voltage_least, limits.voltage_most) == pytest.approx((0.8 * nominal, 1.2 * nominal))
    assert fit_watches(SafetyLimits(), CableSetup(), MotorSetup(family="gm6020", ids=(1, 2, 3))) == SafetyLimits()


def test_a_measured_stiffness_sets_gains_and_the_watch_of_lengths():
    plain, soft = read(EXAMPLE), read(change("cables.stiffness_n_mm", "8.0"))
    assert soft.cables.stiffness == 8000.0
    assert (choose_stiffness(plain.cables), choose_stiffness(soft.cables)) == (2e4, 8e3)
    gains = [build_winders(presets.PAPER, file)[0].gains for file in (plain, soft)]
    assert gains[1].washout / gains[0].washout == pytest.approx(math.sqrt(0.4))
    assert fit_watches(SafetyLimits(), plain.cables) == SafetyLimits()
    assert fit_watches(SafetyLimits(), soft.cables) == SafetyLimits(compliance=1.25e-4)
    servos = MotorSetup(family="sts", ids=(1, 2, 3))
    file = RobotFile(name="x", bus="sts:/dev/ttyUSB0", motors=servos, cables=CableSetup(stiffness=8e3))
    assert (
        build_winders(presets.PAPER, file)[0].gains.slack_speed
        > build_winders(presets.PAPER, replace(file, cables=CableSetup()))[0].gains.slack_speed
    )


POSITIVE = st.floats(allow_nan=True, allow_infinity=True)


@given(tension=st.none() | POSITIVE, speed=st.none() | POSITIVE, floor=st.none() | POSITIVE)
def test_no_number_raises_a_limit(tension, speed, floor):
    plain = RobotFile(name="x", bus="socketcan:can0", motors=MotorSetup(family="gm6020", ids=(1, 2, 3)))
    most = build_winders(presets.PAPER, plain)[0].limits
    try:
        cables = CableSetup(tension_max=tension, speed_max=speed, tension_floor=floor)
        winders = build_winders(presets.PAPER, replace(plain, cables=cables))
    except DesignError:
        return
    for winder in winders:
        for field in fields(most):
            value, bound = getattr(winder.limits, field.name), getattr(most, field.name)
            if field.name == "tension_floor":
                assert 0.0 < value <= most.tension_ceiling / 2
            elif field.name in ("tension_ceiling", "speed_max"):
                assert 0.0 < value <= bound
            else:
                assert value == bound
        assert winder.limits.torque_max <= plain.motors.data_sheet.torque_max


@given(
    st.binary(max_size=200)
    | st.text(max_size=200).map(str.encode)
    | st.integers(0, 1000).map(lambda n: EXAMPLE.encode()[:n])
)
def test_any_bytes_give_a_file_or_a_refusal(data: bytes):
    told = ""
    try:
        parse_robot_file(data, source="x")
    except (DesignError, ValueError) as error:
        told = str(error)
    assert "\n" not in told


def test_limits_are_lowered():
    most = build_winders(presets.PAPER, read(change("cables.tension_max_n", "60")))[0].limits
    lower = lower_limits(most, CableSetup(tension_max=20.0, speed_max=0.05))
    assert (lower.tension_ceiling, lower.speed_max, lower.tension_max) == (20.0, 0.05, most.tension_max)
    assert math.isclose(lower.drag, most.drag)


def test_the_reference_shows_the_example_and_every_key():
    page = (Path(__file__).parents[3] / "docs/reference/robot_file.md").read_text(encoding="utf-8")
    assert EXAMPLE in page
    names = {f"{table}.{key.name}".lstrip(".") for table, keys in TABLES.items() if table != "servo" for key in keys}
    assert not {name for name in names if f"| `{name}` |" not in page}
