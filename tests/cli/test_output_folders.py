"""No verb replaces a file that it did not write or that was changed since, nor writes where another process writes."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

import spiraltrunk.sim.export_models
import spiraltrunk.workflows.bench
import spiraltrunk.workflows.grasp.trial
import spiraltrunk.workflows.survey.run_survey
import spiraltrunk.workflows.virtual_session.session
from spiraltrunk import cli
from spiraltrunk.errors import RunError
from spiraltrunk.files.output_folder import STATE, open_output

TAKE = ("rest-000=missing.csv", "--axes", "y-up")


class Verb(NamedTuple):
    """A verb that writes a folder."""

    argv: tuple[str, ...]
    writer: str
    names: tuple[str, ...]
    began: str = "the work began"
    option: str = "--out"


VERBS = {
    "grasp": Verb(("grasp", "--no-video"), "grasp", ("result.json", "trunk.toml", "force.png")),
    "grasp with video": Verb(("grasp",), "grasp", ("grasp.mp4", "filmstrip.png")),
    "survey": Verb(("survey",), "survey", ("survey.json", "table.md", "trials.jsonl", "rates.png", "heatmap.png")),
    "validate": Verb(
        ("validate", *TAKE), "validate",
        ("result.json", "trunk.toml", "report.html", "overlay-rest.png", "boxes-rest.png"), "missing.csv",
    ),
    "validate --plan": Verb(
        ("validate", "--plan"), "validate --plan", ("plan.md", "protocol.toml", "schedule.csv", "trunk.toml"),
        "written to",
    ),
    "calibrate": Verb(
        ("calibrate", *TAKE), "calibrate", ("result.json", "trunk.toml", "calibration.png"), "missing.csv"
    ),
    "calibrate --bench": Verb(
        ("calibrate", "--bench", "missing.csv"), "calibrate --bench", ("result.json", "bench.png"), "missing.csv"
    ),
    "calibrate --virtual": Verb(
        ("calibrate",), "calibrate --virtual", ("protocol.toml", "rest-000_1.csv", "bend-dorsal_2.csv"),
        option="--virtual",
    ),
    "export": Verb(("export", "--formats", "urdf"), "export", ("result.json", "trunk.toml")),
    "bench": Verb(("bench",), "bench", ("result.json",)),
}  # fmt: skip


@pytest.fixture(autouse=True)
def work(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The work of every verb ends as it begins."""

    def begin(*_: object, **__: object) -> None:
        raise RunError("the work began")

    monkeypatch.setattr(spiraltrunk.workflows.grasp.trial, "run_trial", begin)
    monkeypatch.setattr(spiraltrunk.workflows.survey.run_survey, "_run_entries", begin)
    monkeypatch.setattr(spiraltrunk.workflows.virtual_session.session, "simulate_session", begin)
    monkeypatch.setattr(spiraltrunk.sim.export_models, "write_models", begin)
    monkeypatch.setattr(spiraltrunk.workflows.bench, "CLAIMS", {"fast": begin})
    monkeypatch.chdir(tmp_path)


def run(verb: Verb, folder: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    code = cli.main([*verb.argv, verb.option, str(folder)])
    return code, capsys.readouterr().err


def write_own(folder: Path, verb: Verb, name: str) -> Path:
    with open_output(folder, verb.writer) as output, output.draft() as draft:
        (draft / name).write_text("of an earlier run")
    return folder / name


def write_foreign(folder: Path, verb: Verb, name: str) -> Path:
    folder.mkdir()
    (folder / name).write_text("mine")
    return folder / name


def write_changed(folder: Path, verb: Verb, name: str) -> Path:
    path = write_own(folder, verb, name)
    path.write_text("of an earlier run, with my notes")
    return path


def write_others(folder: Path, verb: Verb, name: str) -> Path:
    return write_own(folder, verb._replace(writer="another"), name)


KINDS = {
    write_foreign: "no run of '{writer}' wrote it",
    write_changed: "it was changed since '{writer}' wrote it",
    write_others: "'another' wrote it, and this is '{writer}'",
}
CASES = [(each, name) for each, verb in VERBS.items() for name in verb.names]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("each", "name"), CASES)
def test_a_file_that_is_not_its_own_is_refused_before_the_work(
    each: str, name: str, kind: Callable[[Path, Verb, str], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    verb = VERBS[each]
    path = kind(tmp_path / "out", verb, name)
    before = path.read_bytes()
    code, said = run(verb, tmp_path / "out", capsys)
    reason = KINDS[kind].format(writer=verb.writer)
    assert code == 2
    assert said.startswith("spiraltrunk: error: ")
    assert said.endswith(
        f"'{path}' is not replaced: {reason}; allowed: another folder, or this one once that file is moved away\n"
    )
    assert said.count("\n") == 1
    assert path.read_bytes() == before
    assert {each.name for each in (tmp_path / "out").iterdir()} <= {name, STATE}


@pytest.mark.parametrize(("each", "name"), [case for case in CASES if case[1] not in ("survey.json", "trials.jsonl")])
def test_its_own_file_is_no_obstacle(each: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    verb = VERBS[each]
    write_own(tmp_path / "out", verb, name)
    _, said = run(verb, tmp_path / "out", capsys)
    assert verb.began in said
    assert "not replaced" not in said


@pytest.mark.parametrize("each", VERBS)
def test_a_folder_that_another_process_writes_to_is_refused(
    each: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with open_output(tmp_path / "out", "another"):
        code, said = run(VERBS[each], tmp_path / "out", capsys)
    assert code == 2
    option = VERBS[each].option
    assert said == (
        f"spiraltrunk: error: {option}: another process is writing to '{tmp_path / 'out'}'; allowed: another folder, "
        "or this one once that process has ended\n"
    )


def test_a_plan_is_written_again_and_a_protocol_that_was_edited_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Passed back as the page on motion capture says, it stays with its comments, and the plan follows it."""
    verb, out = VERBS["validate --plan"], tmp_path / "out"
    for _ in range(2):
        assert run(verb, out, capsys)[0] == 0
    protocol = out / "protocol.toml"
    edited = "# Mine.\n" + protocol.read_text().replace("slack_mm = [0, 0, 0]", "slack_mm = [1, 2, 3]")
    protocol.write_text(edited)
    assert run(verb, out, capsys)[0] == 2
    plan = (out / "plan.md").read_text()
    assert protocol.read_text() == edited
    assert run(verb._replace(argv=(*verb.argv, "--protocol", str(protocol))), out, capsys)[0] == 0
    assert protocol.read_text() == edited
    assert (out / "plan.md").read_text() != plan


FILES = {"design": (("design", "--out"), "trunk.toml"), "shape": (("shape", "--plot"), "shape.svg")}


@pytest.mark.parametrize("each", FILES)
def test_a_single_file_is_replaced_unless_it_is_the_users(
    each: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    argv, name = FILES[each]
    path = tmp_path / name
    for _ in range(2):
        assert cli.main([*argv, str(path)]) == 0
    for text in (path.read_text() + "\n", "mine"):
        path.write_text(text)
        capsys.readouterr()
        assert cli.main([*argv, str(path)]) == 2
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err == (
            f"spiraltrunk: error: {argv[-1]}: '{path}' is not replaced: it is no file of spiraltrunk's, or was changed "
            "since; allowed: a new file, or move that one away\n"
        )
        assert path.read_text() == text
    assert list(tmp_path.iterdir()) == [path]


def test_a_design_is_not_replaced_by_the_run_that_reads_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "trunk.toml"
    assert cli.main(["design", "--out", str(path)]) == 0
    before = path.read_bytes()
    capsys.readouterr()
    assert cli.main(["grasp", "--design", "trunk.toml", "--out", "."]) == 2
    assert "'trunk.toml' is not replaced: no run of 'grasp' wrote it" in capsys.readouterr().err
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))
from spiraltrunk import cli
sys.exit(cli.main(sys.argv[1:]))
"""
"""A verb to which every file of more than 500 bytes is one too many for the disc."""


@pytest.mark.parametrize(
    ("argv", "name"),
    [
        (("design", "--out", "{}/trunk.toml"), "trunk.toml"),
        pytest.param(("validate", "--plan", "--out", "{}"), "plan.md", marks=pytest.mark.slow),
        pytest.param(("calibrate", "--bench", "loads.csv", "--out", "{}"), "bench.png", marks=pytest.mark.slow),
    ],
)
def test_a_full_disc_is_one_line_with_the_file_that_could_not_be_written(
    argv: tuple[str, ...], name: str, tmp_path: Path
) -> None:
    rows = "".join(f"1,0.05,{10 * angle},{angle}\n" for angle in range(0, 31, 3))
    (tmp_path / "loads.csv").write_text("joint,lever_arm_m,mass_g,angle_deg\n" + rows)
    out = tmp_path / "out"
    command = [sys.executable, "-c", LIMITED, *(word.format(out) for word in argv)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout) == (2, "")
    said = [line for line in ran.stderr.splitlines() if "compiling" not in line]
    assert len(said) == 1
    assert f"'{out / name}' cannot be written: File too large; allowed: a place that can be made and written" in said[0]
    assert [path.name for path in tmp_path.iterdir()] == ["loads.csv"]
