"""An output folder: all files or none, none of another's, one process at a time, and no file lost by a kill."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from spiraltrunk.errors import OutputError
from spiraltrunk.files import output_folder
from spiraltrunk.files.output_folder import STATE, OutputFolder, open_output

TEXTS = {"result.json": "{}", "table.md": "a table", "parts/horn.stl": "a horn"}


def write(folder: Path, texts: dict[str, str], writer: str = "grasp", *, is_partial: bool = False) -> OutputFolder:
    with open_output(folder, writer, texts) as output, output.draft(is_partial=is_partial) as draft:
        for name, text in texts.items():
            (draft / name).parent.mkdir(exist_ok=True)
            (draft / name).write_text(text)
    return output


def read(folder: Path) -> dict[str, str]:
    """All files that are not hidden."""
    return {
        str(path.relative_to(folder)): path.read_text()
        for path in folder.rglob("*")
        if path.is_file() and STATE not in path.parts
    }


def test_files_move_in_at_the_end(tmp_path: Path) -> None:
    out = tmp_path / "a" / "b"
    with open_output(out, "grasp") as output, output.draft() as draft:
        (draft / "result.json").write_text("{}")
        assert read(out) == {}
    assert read(out) == {"result.json": "{}"}
    assert [path.name for path in (out / STATE).iterdir()] == ["manifest.json"]


def test_a_failure_leaves_what_was_there(tmp_path: Path) -> None:
    write(tmp_path, TEXTS)

    def fail() -> None:
        with open_output(tmp_path, "grasp") as output, output.draft() as draft:
            (draft / "result.json").write_text("new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert read(tmp_path) == TEXTS
    assert [path.name for path in (tmp_path / STATE).iterdir()] == ["manifest.json"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_waits_until_all_files_have_moved_in(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(number: int, frame: object) -> None:
        raise KeyboardInterrupt(number)

    def replace(path: Path, place: Path) -> Path:
        os.kill(os.getpid(), number)
        return move(path, place)

    move, before = Path.replace, signal.signal(number, stop)
    monkeypatch.setattr(Path, "replace", replace)
    try:
        with pytest.raises(KeyboardInterrupt):
            write(tmp_path, TEXTS)
        assert signal.getsignal(number) is stop
    finally:
        signal.signal(number, before)
    assert read(tmp_path) == TEXTS
    assert [path.name for path in (tmp_path / STATE).iterdir()] == ["manifest.json"]


def test_a_failure_removes_only_folders_that_it_made(tmp_path: Path) -> None:
    (tmp_path / "kept").mkdir()
    with pytest.raises(KeyboardInterrupt), open_output(tmp_path / "kept" / "made" / "too", "grasp"):
        raise KeyboardInterrupt
    assert list(tmp_path.rglob("*")) == [tmp_path / "kept"]


def test_own_files_are_replaced_and_those_left_over_removed(tmp_path: Path) -> None:
    write(tmp_path, TEXTS)
    (tmp_path / "mine.txt").write_text("mine")
    output = write(tmp_path, {"result.json": "again"})
    assert output.removed == ["parts/horn.stl", "table.md"]
    assert read(tmp_path) == {"result.json": "again", "mine.txt": "mine"}
    assert not (tmp_path / "parts").exists()
    write(tmp_path, {"table.md": "more"}, is_partial=True)
    assert read(tmp_path) == {"result.json": "again", "mine.txt": "mine", "table.md": "more"}


def test_what_is_left_over_and_was_changed_since_stays(tmp_path: Path) -> None:
    write(tmp_path, TEXTS)
    (tmp_path / "table.md").write_text("mine")
    assert write(tmp_path, {"result.json": "again"}).removed == ["parts/horn.stl"]
    assert read(tmp_path) == {"result.json": "again", "table.md": "mine"}
    with pytest.raises(OutputError, match=r"table\.md' is not replaced: no run of 'grasp' wrote it"):
        write(tmp_path, TEXTS)


def occupy_by_file(folder: Path) -> None:
    (folder / "result.json").write_text("mine")


def occupy_by_change(folder: Path) -> None:
    write(folder, TEXTS)
    (folder / "result.json").write_text("{} ")


def occupy_by_command(folder: Path) -> None:
    write(folder, {"result.json": "calibrated"}, "calibrate")


def occupy_by_link(folder: Path) -> None:
    write(folder, TEXTS)
    (folder / "result.json").rename(folder / "kept.json")
    (folder / "result.json").symlink_to("kept.json")


def occupy_by_folder(folder: Path) -> None:
    (folder / "result.json").mkdir()


def occupy_parent(folder: Path) -> None:
    (folder / "parts").write_text("mine")


OCCUPIED = {
    occupy_by_file: "no run of 'grasp' wrote it",
    occupy_by_change: "it was changed since 'grasp' wrote it",
    occupy_by_command: "'calibrate' wrote it, and this is 'grasp'",
    occupy_by_link: "it was changed since",
    occupy_by_folder: "no run of 'grasp' wrote it",
    occupy_parent: "parts' is no folder",
}


@pytest.mark.parametrize("occupy", OCCUPIED)
def test_what_is_not_the_commands_own_is_refused(occupy: Callable[[Path], None], tmp_path: Path) -> None:
    occupy(tmp_path)
    before = read(tmp_path)
    with pytest.raises(OutputError, match=OCCUPIED[occupy]) as caught, open_output(tmp_path, "grasp", TEXTS):
        pytest.fail("the work began")
    assert "\n" not in str(caught.value)
    assert read(tmp_path) == before


def test_what_appears_during_the_work_is_refused_at_its_end(tmp_path: Path) -> None:
    def work() -> None:
        with open_output(tmp_path, "grasp", TEXTS) as output, output.draft() as draft:
            (draft / "result.json").write_text("new")
            (tmp_path / "result.json").write_text("mine")

    with pytest.raises(OutputError, match=r"result\.json' is not replaced"):
        work()
    assert read(tmp_path) == {"result.json": "mine"}


def test_a_file_with_the_new_content_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "protocol.toml").write_text("the same")
    before = (tmp_path / "protocol.toml").stat().st_ino
    with open_output(tmp_path, "plan") as output, output.draft() as draft:
        (draft / "protocol.toml").write_text("the same")
        (draft / "plan.md").write_text("a plan")
    assert read(tmp_path) == {"protocol.toml": "the same", "plan.md": "a plan"}
    assert (tmp_path / "protocol.toml").stat().st_ino == before


def test_a_folder_is_written_by_one_at_a_time(tmp_path: Path) -> None:
    with open_output(tmp_path / "out", "grasp") as output:
        with pytest.raises(OutputError, match=r"another process is writing to '.*out'; allowed: another folder"):
            write(tmp_path / "out", TEXTS)
        with open_output(output, "grasp") as same:
            assert same is output
        with output.draft() as draft:
            (draft / "result.json").write_text("{}")
    assert read(tmp_path / "out") == {"result.json": "{}"}
    write(tmp_path / "out", TEXTS)


HOLDS = """
import sys, time
from spiraltrunk.files.output_folder import open_output
with open_output(sys.argv[1], "grasp") as output, output.draft() as draft:
    (draft / "result.json").write_text("half")
    print("open", flush=True)
    time.sleep(60)
"""


def test_another_process_holds_the_folder_until_it_is_killed(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with subprocess.Popen([sys.executable, "-c", HOLDS, str(out)], stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        assert running.stdout.readline() == "open\n"
        with pytest.raises(OutputError, match="another process is writing"):
            write(out, TEXTS)
        running.send_signal(signal.SIGKILL)
    assert len(list((out / STATE).rglob("*"))) == 3, "the killed process leaves lock and draft"
    write(out, TEXTS)
    assert read(out) == TEXTS
    assert [path.name for path in (out / STATE).iterdir()] == ["manifest.json"]


OLD = {"result.json": "old", "a.txt": "old a", "b.txt": "old b", "gone.txt": "old"}
NEW = {"result.json": "new", "a.txt": "new a", "c.txt": "new c", "parts/d.txt": "new d"}

DIES = """
import json, os, signal, sys
from spiraltrunk.files.output_folder import open_output
folder, last, texts, left = sys.argv[1], int(sys.argv[2]), json.loads(sys.argv[3]), []

def watch(event, arguments):
    if event in ("os.mkdir", "os.rename", "os.remove", "os.rmdir") or event == "open" and arguments[2] & os.O_CREAT:
        left.append(event)
        if len(left) > last:
            os.kill(os.getpid(), signal.SIGKILL)

with open_output(folder, "grasp", texts) as output:
    sys.addaudithook(watch)
    with output.draft() as draft:
        for name, text in texts.items():
            (draft / name).parent.mkdir(exist_ok=True)
            (draft / name).write_text(text)
print(len(left))
"""
"""A run that is killed before one of the calls that change the disc."""


def run_until(folder: Path, last: int) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", DIES, str(folder), str(last), json.dumps(NEW)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_a_kill_at_any_moment_costs_no_file(tmp_path: Path) -> None:
    """Nothing of the user's is lost, what is there is whole, and the next run goes on."""
    write(tmp_path / "all", OLD)
    steps = int(run_until(tmp_path / "all", 1000).stdout)
    assert steps > 20
    for last in range(steps):
        folder = tmp_path / str(last)
        write(folder, OLD)
        (folder / "mine.txt").write_text("mine")
        assert run_until(folder, last).returncode == -signal.SIGKILL
        held = read(folder)
        assert held.pop("mine.txt") == "mine"
        assert all(text in (OLD.get(name), NEW.get(name)) for name, text in held.items())
        assert held.get("result.json") != "old" or held == OLD
        assert held.get("result.json") != "new" or held == NEW
        write(folder, NEW)
        assert read(folder) == NEW | {"mine.txt": "mine"}


DAMAGED = {
    "noise": os.urandom(100),
    "nested": b"[" * 200_000,
    "a list": b"[]",
    "a number": b"7",
    "another schema": b'{"schema": 2, "files": {}}',
    "no files": b'{"schema": 1}',
    "files in a list": b'{"schema": 1, "files": ["result.json"]}',
    "a file above": json.dumps({"schema": 1, "files": {"../a": {"writer": "a", "sha256": []}}}).encode(),
    "a file elsewhere": json.dumps({"schema": 1, "files": {"/etc/a": {"writer": "a", "sha256": []}}}).encode(),
    "no writer": json.dumps({"schema": 1, "files": {"a": {"writer": 7, "sha256": []}}}).encode(),
    "no digest": json.dumps({"schema": 1, "files": {"a": {"writer": "a", "sha256": ["x"]}}}).encode(),
    "too long": b" " * 4_000_001,
}


@pytest.mark.parametrize("how", DAMAGED)
def test_a_damaged_manifest_is_one_line(how: str, tmp_path: Path) -> None:
    write(tmp_path, TEXTS)
    manifest = tmp_path / STATE / "manifest.json"
    manifest.write_bytes(DAMAGED[how])
    with pytest.raises(OutputError, match=r"manifest\.json' is damaged") as caught:
        write(tmp_path, TEXTS)
    assert "\n" not in str(caught.value)
    assert manifest.read_bytes() == DAMAGED[how]
    assert read(tmp_path) == TEXTS


def test_nothing_outside_the_folder_is_removed(tmp_path: Path) -> None:
    """Even where a folder of its own was replaced by a link."""
    write(tmp_path / "out", TEXTS)
    shutil.move(tmp_path / "out" / "parts", tmp_path / "kept")
    (tmp_path / "kept" / "horn.stl").write_text("mine")
    (tmp_path / "out" / "parts").symlink_to(tmp_path / "kept")
    write(tmp_path / "out", {"result.json": "again"})
    assert (tmp_path / "kept" / "horn.stl").read_text() == "mine"


def fill(place: str) -> Iterator[OSError]:
    """Errors as different writers raise them on a full disc."""
    message = os.strerror(errno.ENOSPC)
    yield OSError(errno.ENOSPC, message)
    yield OSError(errno.ENOSPC, message, place)
    yield OSError(errno.ENOSPC, message, "/usr/share/mesh.stl", None, place)  # As shutil.copyfile.


def test_a_full_disc_is_told_with_the_file_that_could_not_be_written(tmp_path: Path) -> None:
    def fail(error: OSError) -> None:
        with open_output(tmp_path / "out", "export") as output, output.draft() as draft:
            (draft / "parts").mkdir()
            (draft / "parts" / "horn.stl").write_text("half")
            raise error

    for error in fill(str(tmp_path / "out" / STATE / "draft" / "parts" / "horn.stl")):
        with pytest.raises(OutputError) as caught:
            fail(error)
        told = f"'{tmp_path / 'out' / 'parts' / 'horn.stl'}' cannot be written: No space left on device; allowed: "
        assert str(caught.value).startswith(told)
        assert list(tmp_path.iterdir()) == []


def test_an_error_of_another_file_is_no_error_of_the_output(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught, open_output(tmp_path, "export") as output, output.draft():
        (tmp_path / "source.stl").read_text()
    assert caught.value.filename == str(tmp_path / "source.stl")


@pytest.mark.parametrize("place", ["taken", "taken/below", "/proc/none", "x" * 300])
def test_a_place_that_cannot_be_a_folder_is_one_line(place: str, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    with pytest.raises(OutputError, match=r"is a file; allowed: a folder|cannot be written: .*; allowed: a folder"):
        write(tmp_path / place, TEXTS)
    assert read(tmp_path) == {"taken": "mine"}


def test_without_locks_there_is_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """As on some network file systems."""
    from spiraltrunk.files import lock

    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(lock.fcntl, "flock", refuse)
    monkeypatch.setattr("logging.Logger.propagate", True, raising=False)
    write(tmp_path, TEXTS)
    assert read(tmp_path) == TEXTS
    assert output_folder.STATE in caplog.text
