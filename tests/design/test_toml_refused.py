"""Whatever bytes a design file has, it is a design or is refused in one clear line that names the key."""

import os
import random
import stat
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from spiraltrunk.design import TrunkDesign, format_design, load_design, write_design
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.schema import TABLES
from spiraltrunk.errors import DesignError

MINIMAL = 'name = "small"\n[spiral]\na_mm = 26.0\nb = 0.16\n'
KEYS = [(table, key) for table, keys in TABLES.items() for key in keys]

in_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
"""The folder is shared by all examples of a test: each writes its file anew."""


def dotted(table, name):
    return f"{table}.{name}" if table else name


# What is refused, by name.

WRONG = {
    "TEXT": ["1", "true", "[]", "{}", "1.5", "1979-05-27", "['a']"],
    "COUNT": ["18.0", "true", "'18'", "[18]", "{}", "nan", "1979-05-27"],
    "NUMBER": ["true", "'1'", "[1.0]", "{}", "nan", "inf", "-inf", "1e400", "1e999999999", "1979-05-27", "07:32:00"],
    "NUMBERS": ["1.0", "true", "'1'", "{}", "[true]", "['1']", "[[1.0]]", "[{}]", "[nan]", "[inf]", "[1e400]"],
}  # fmt: skip


@pytest.mark.parametrize(("table", "key"), KEYS)
def test_every_key_refuses_values_of_another_kind(edit, refusal, table, key):
    for value in WRONG[key.kind.name]:
        error = refusal(edit(table, key.name, value))
        assert error.name.split("[")[0] == dotted(table, key.name)
        assert key.kind.value in str(error) or "a finite number" in str(error)


@pytest.mark.parametrize("table", list(TABLES))
@pytest.mark.parametrize(
    "name", ["radius", "a_m", "x", "'two\\nlines'", '"two\\nlines"', '""', '"' + "x" * 300 + '"', '"\u202e"']
)
def test_an_unknown_key_is_refused_with_those_that_exist(full, refusal, table, name):
    head = f"[{table}]\n" if table else "schema = 1\n"
    text = format_design(full).replace(head, f"{head}{name} = 1\n", 1)
    error = refusal(text)
    assert error.name.startswith(f"{table}." if table else "")
    assert error.name.isprintable()
    assert all(key.name in str(error) for key in TABLES[table])


def test_an_unknown_table_is_refused_with_those_that_exist(refusal):
    error = refusal(MINIMAL + "[trunk]\n")
    assert error.name == "trunk"
    assert "name, schema, [spiral], [joint], [cable], [mass], [gripper], [housing], [arm]" in str(error)


@pytest.mark.parametrize("table", [table for table in TABLES if table])
@pytest.mark.parametrize("value", ["1", "'text'", "[]", "[{}]", "true"])
def test_a_table_that_is_none_is_refused(refusal, table, value):
    head, _, rest = MINIMAL.partition("\n")
    text = f"{head}\n{table} = {value}\n" + ("" if table == "spiral" else rest)
    error = refusal(text)
    assert error.name == table
    assert "a table with the keys" in str(error)


@pytest.mark.parametrize(
    ("schema", "told"),
    [("0", "0"), ("2", "2"), ("'1'", "'1'"), ("[1]", "an array of 1"), ("{}", "a table"), ("-1", "-1")],
)
def test_another_schema_is_refused(refusal, schema, told):
    assert f"; schema is {told}, not 1" in str(refusal(f"schema = {schema}\n{MINIMAL}"))


def test_values_out_of_range_are_refused_by_the_design_itself(edit, refusal):
    assert refusal(edit("joint", "radius_mm", "-1.0")).name == "joint.radius_mm"
    assert refusal(edit("spiral", "a_mm", "1e-999999")).name == "spiral.a_mm"
    assert refusal(edit("spiral", "b", "-1e300")).name == "spiral.b"
    assert refusal(edit("spiral", "n_section", "10")).name == "joint.stiffness_nm_per_rad"
    assert refusal("name = 'x'").name == "spiral.a_mm"


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("spiral", "a_mm"), "-1", "spiral.a_mm is -1.0; allowed: a finite number, above 0, below 1e+06"),
        (("spiral", "a_mm"), "-1.50", "spiral.a_mm is -1.5; allowed: a finite number, above 0, below 1e+06"),
        (("spiral", "b"), "7", "spiral.b is 7.0; allowed: a finite number, above 0, below 2"),
        (("spiral", "k"), "1", "spiral.k is 1.0; allowed: a finite number, above 0.365931, below 1"),
        (("spiral", "delta_theta_deg"), "90",
         "spiral.delta_theta_deg is 90.0; allowed: a finite number, above 0, below 90"),
        (("spiral", "theta_tip_deg"), "1e9",
         "spiral.theta_tip_deg is 1000000000.0; allowed: a finite number, above -5729.58, below 5729.58"),
        (("spiral", "n_section"), "201", "spiral.n_section is 201; allowed: a whole number from 2 to 200"),
        (("joint", "youngs_modulus_mpa"), "0",
         "joint.youngs_modulus_mpa is 0.0; allowed: a finite number, at least 0.001, below 1e+06"),
        (("joint", "radius_mm"), "40", "joint.radius_mm is 40.0; allowed: a finite number, below 26.4"),
        (("mass", "sections_g"), "[-3.0]",
         "mass.sections_g[0] is -3.0; allowed: a finite number, at least 1e-09, at most 1e+06"),
        (("mass", "sections_g"), "[3.0]", "mass.sections_g is 1 numbers; allowed: 18 numbers"),
        (("cable", "angles_deg"), "[0, 1.50, 2]",
         "cable.angles_deg is [0.0, 1.5, 2.0]; allowed: cables at least 5 deg apart"),
        (("housing", "mass_kg"), "true", "housing.mass_kg is true; allowed: a finite number"),
        (("arm", "roll_deg"), "1979-05-27", "arm.roll_deg is 1979-05-27; allowed: a finite number"),
        (("spiral", "a_mm"), None, "spiral.a_mm is missing; allowed: the key a_mm of spiral, a finite number"),
        (("", "name"), None, "name is missing; allowed: the key name, a text"),
        (("", "name"), "{}", "name is a table; allowed: a text"),
        (("gripper", "mount_radius_mm"), "1e5",
         "gripper.mount_radius_mm is 100000.0; allowed: a finite number, at least 0, below 10000"),
    ],
)  # fmt: skip
def test_the_message_tells_file_key_value_and_range_as_the_file_does(edit, refusal, place, value, message):
    file, told = str(refusal(edit(*place, value))).split(": ", 1)
    assert file.endswith("trunk.toml'")
    assert told == message


ABSURD = {
    "joint": {"radius_mm": "1e-305", "length_mm": "1e-305", "youngs_modulus_mpa": "1e-300"},
    "cable": {"tension_max_n": "1e-300", "angles_deg": "[0, 120, 1e300]"},
    "mass": {"density_kg_per_m3": "1e-300"},
    "gripper": {"delta_theta_deg": "1e-300", "finger_length_mm": "1e-300", "finger_width_mm": "1e-9",
                "mass_g": "1e-300", "stiffness_nm_per_rad": "1e-300", "tension_max_n": "1e-300"},
    "housing": {"radius_mm": "1e-300", "length_mm": "1e-9", "mass_kg": "1e-300", "neck_length_mm": "1e-300",
                "neck_mass_kg": "1e-300"},
    "arm": {"home_deg": "[1e300, 0, 0]"},
}  # fmt: skip
"""Numbers that nothing has and that were once let through."""


@pytest.mark.parametrize(("table", "name"), [(table, name) for table, names in ABSURD.items() for name in names])
def test_an_absurd_number_is_refused_at_its_key(edit, refusal, table, name):
    error = refusal(edit(table, name, ABSURD[table][name]))
    assert error.name.split("[")[0] == f"{table}.{name}"
    assert "allowed: a finite number, at least" in str(error)


def test_a_tip_thinner_than_anyone_makes_is_refused_with_the_reason(edit, refusal):
    error = refusal(edit("spiral", "a_mm", "1e-3"))
    assert "trunk.toml': width of the tip is " in str(error)
    assert "mm; allowed: at least 0.01 mm: fewer turns or sections" in str(error)


# What is no design file.


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("name = \n", "at line 1"),
        (MINIMAL + "[joint\n", "line 5"),
        (MINIMAL + MINIMAL, "valid TOML"),
        ("name = 'x'\r\r", "valid TOML"),
        ("x = " + "[" * 100_000, "nested too deeply"),
        ("schema = " + "1" * 6000, "too many digits"),
        *((key + " = 0x" + "f" * 4200, "too many digits") for key in ("schema", "name", "other", "[spiral]\na_mm")),
        ("[spiral]\nn_section = [1, {a = 0o" + "7" * 5000 + "}]", "too many digits"),
        (b"name = '\xff'", "no text in UTF-8"),
        (b"\xff\xfen\x00", "no text in UTF-8"),
        ("a." * 5000 + "b = 1", "more than 250 dots"),
        ("# none\n" * 30_000, "more than 200000 bytes"),
        (b"\x00", "valid TOML"),
    ],
)
def test_text_that_is_no_toml_is_refused_with_the_reason(refusal, text, reason):
    error = refusal(text)
    assert error.name == "design"
    assert reason in str(error)


def test_a_missing_file_lists_the_presets(tmp_path):
    for missing in (
        "papr",
        tmp_path / "none.toml",
        str(tmp_path / "none" / "trunk.toml"),
        "x" * 5000,
        "a\0b",
        "\udcff",
    ):
        with pytest.raises(
            DesignError, match=r"a preset \(paper, paper-large-grip, spirob-15, spirob-1m\) or a .toml file"
        ):
            load_design(missing)


@pytest.mark.parametrize("given_as", [None, 1, b"paper", ["paper"], True, PAPER])
def test_what_is_no_path_is_refused(given_as):
    with pytest.raises(DesignError, match="allowed: str or Path"):
        load_design(given_as)
    with pytest.raises(DesignError, match="allowed: str or Path"):
        write_design(PAPER, given_as)


def test_a_folder_is_refused(tmp_path):
    with pytest.raises(DesignError, match="this is a folder"):
        load_design(tmp_path)


def test_a_pipe_is_refused_without_waiting_for_it(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(DesignError, match="no regular file"):
        load_design(tmp_path / "pipe")
    with pytest.raises(DesignError, match="no regular file"):
        write_design(PAPER, tmp_path / "pipe")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_an_unreadable_file_is_refused(tmp_path, monkeypatch):
    path = write_design(PAPER, tmp_path / "trunk.toml")

    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(DesignError, match="Permission denied"):
        load_design(path)


def test_the_error_keeps_both_ends_of_a_long_path(tmp_path):
    with pytest.raises(DesignError, match=r"allowed: .*No such file"):
        load_design(tmp_path / ("long" * 30) / "trunk.toml")
    with pytest.raises(DesignError, match=r"/trunk\.toml'; allowed: "):
        load_design(tmp_path / ("long" * 30) / "trunk.toml")


# Whatever bytes come.


def load_or_refuse(load_text, data):
    try:
        return isinstance(load_text(data), TrunkDesign)
    except DesignError as error:
        return "\n" not in str(error) and len(str(error)) < 1000


@in_folder
@given(st.binary(max_size=300) | st.text(max_size=300).map(lambda text: text.encode("utf-8", "surrogatepass")))
def test_any_bytes_are_a_design_or_refused(load_text, data):
    assert load_or_refuse(load_text, data)


TOKENS = [b"nan", b"inf", b"-", b"[", b"]", b"{", b"}", b"=", b"'", b'"', b"\n", b"\r", b".", b",", b"#", b"_", b"e-",
          b"0", b"9" * 400, b"1e999", b"true", b"1979-05-27", b"\\u0000", b"\x00", b"\xff", b"\xc3\xa9",
          b"[spiral]", b"[[joint]]"]  # fmt: skip


def mutate(chance, data):
    """The bytes after one to four random cuts, flips, swaps, repeats and inserted tokens."""
    for _ in range(chance.randint(1, 4)):
        start = chance.randrange(len(data) + 1)
        end = min(len(data), start + chance.choice([0, 1, 1, 2, 5, 20, 200]))
        piece = chance.choice([b"", bytes([chance.randrange(256)]), chance.choice(TOKENS), data[start:end] * 2])
        data = data[:start] + piece + data[end:]
    return data


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2, 3))])
def test_mutated_files_are_designs_or_refused(full, load_text, seed):
    chance = random.Random(seed)
    whole = format_design(full).encode()
    broken = [data for data in (mutate(chance, whole) for _ in range(1000)) if not load_or_refuse(load_text, data)]
    assert broken == []
