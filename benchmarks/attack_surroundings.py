"""Every verb of the command line in bad surroundings: full discs, missing packages, closed streams, other locales.

Claim: whatever surrounds it, a command ends with its result, or with exit 2 and one line that says what to do; it
prints no traceback and leaves no part of a result. Each command of `COMMANDS` runs in a process of its own in each of
the surroundings of `SURROUNDINGS`. Runs are appended to ``runs.jsonl`` in the work folder; the same call goes on
after the last. Full and read-only discs are small file systems in memory where the user may mount them; elsewhere a
limit on the size of files stands for a full disc, and a folder without the permission to write for a read-only one.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SECONDS = 600.0
"""Time that a command may take [s]."""

COMMANDS = {
    "design": ["design", "--out", "OUT/trunk.toml", "--json"],
    "shape": ["shape", "--dorsal-mm", "30", "--json"],
    "shape --plot": ["shape", "--dorsal-mm", "30", "--plot", "OUT/shape.png", "--json"],
    "grasp": ["grasp", "kick", "--no-video", "--out", "OUT", "--json"],
    "survey": ["survey", "--strategies", "kick", "--trials", "2", "--workers", "2", "--out", "OUT", "--json"],
    "validate": ["validate", "TAKES/rest-045_1.csv", "--protocol", "TAKES/protocol.toml", "--out", "OUT", "--json"],
    "validate, as text": ["validate", "TAKES/rest-045_1.csv", "--protocol", "TAKES/protocol.toml", "--out", "OUT"],
    "validate C3D": ["validate", "TAKES/rest-045_1.c3d", "--protocol", "TAKES/protocol.toml", "--json"],
    "calibrate": ["calibrate", "--bench", "TAKES/bench.csv", "--out", "OUT", "--json"],
    "export": ["export", "--parts", "horn", "--formats", "step", "stl", "3mf", "--out", "OUT", "--json"],
    "export models": ["export", "--formats", "mjcf", "urdf", "--out", "OUT", "--json"],
    "export pool": ["export", "--parts", "horn", "drums", "--formats", "stl", "--out", "OUT", "--json"],
    "object": ["object", "ball-60", "--json"],
    "bench": ["bench", "--help"],
}
"""Arguments of each command; OUT is the folder to write to, TAKES holds recordings."""

SMALL = ("design", "shape", "validate", "calibrate", "bench")
"""Commands of the short version in the tests."""

PACKAGES = ("mujoco", "mink", "trimesh", "matplotlib", "rich", "build123d", "ezc3d", "av", "PIL", "shtab")
"""Packages that are hidden, one at a time."""

STARTS = ("spawn", "fork", "forkserver")
"""Ways to start processes."""

HIDE = """
import importlib.machinery, importlib.metadata, multiprocessing, os
hidden = os.environ.get("ATTACK_HIDDEN")
if hidden:
    find, read = importlib.machinery.PathFinder.find_spec, importlib.metadata.Distribution.from_name
    importlib.machinery.PathFinder.find_spec = classmethod(
        lambda cls, name, *more: None if name.partition(".")[0] == hidden else find(name, *more))
    def from_name(name):
        if name == hidden:
            raise importlib.metadata.PackageNotFoundError(name)
        return read(name)
    importlib.metadata.Distribution.from_name = staticmethod(from_name)
if os.environ.get("ATTACK_START"):
    multiprocessing.set_start_method(os.environ["ATTACK_START"])
"""
"""The ``sitecustomize`` of the processes: it hides a package, or sets how processes start."""


FILLER = ".filler"
"""File that takes all of a full disc."""


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """Something that a command has around it."""

    environment: dict[str, str] = field(default_factory=dict)
    """Variables that are set, or, where the value is empty, are not there."""
    disc: str = ""
    """Size of the disc of ``--out``, "full" or "read-only"; empty for the disc of the work folder."""
    closed: tuple[int, ...] = ()
    """Descriptors that are closed at the start."""
    sink: str = ""
    """Where standard output goes: "/dev/full", "pipe" for one whose reader is gone; empty for a file."""
    error_sink: str = ""
    """The same of standard error."""
    name: str = "out"
    """Name of the folder."""
    refused: str = "never"
    """When exit 2 is right: never, "may" for always, "writes" for commands that write files, where it must be."""
    advice: str = ""
    """What the one line must contain where the command is refused."""


SURROUNDINGS: dict[str, Surroundings] = {
    "as it is": Surroundings(),
    "full disc": Surroundings(disc="full", refused="writes"),
    "disc of 64 kB": Surroundings(disc="64k", refused="may"),
    "disc of 512 kB": Surroundings(disc="512k", refused="may"),
    "read-only folder": Surroundings(disc="read-only", refused="writes"),
    **{
        f"without {name}": Surroundings(environment={"ATTACK_HIDDEN": name}, refused="may", advice="pip install")
        for name in PACKAGES
    },
    "40 columns": Surroundings(environment={"COLUMNS": "40", "LINES": "5"}),
    "1 column": Surroundings(environment={"COLUMNS": "1"}),
    "standard input closed": Surroundings(closed=(0,)),
    "standard output closed": Surroundings(closed=(1,)),
    "standard error closed": Surroundings(closed=(2,)),
    "all three closed": Surroundings(closed=(0, 1, 2)),
    "reader of standard output gone": Surroundings(sink="pipe"),
    "reader of standard error gone": Surroundings(error_sink="pipe"),
    "standard output to a full disc": Surroundings(sink="/dev/full", refused="may"),
    "standard error to a full disc": Surroundings(error_sink="/dev/full", refused="may"),
    "LANG=C, non-ASCII paths": Surroundings(
        environment={"LANG": "C", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}, name="räum 試 'x'"
    ),
    "LANG=C.UTF-8, path that is no UTF-8": Surroundings(
        environment={"LANG": "C.UTF-8", "LC_ALL": "C.UTF-8"}, name="a\udcff b", refused="may"
    ),
    "no HOME": Surroundings(environment={"HOME": "/nonexistent", "XDG_CACHE_HOME": "", "XDG_CONFIG_HOME": ""}),
    "TERM=dumb, NO_COLOR": Surroundings(environment={"TERM": "dumb", "NO_COLOR": "1"}),
    "warnings are errors": Surroundings(environment={"PYTHONWARNINGS": "error::RuntimeWarning"}),
    **{f"processes by {way}": Surroundings(environment={"ATTACK_START": way}) for way in STARTS},
}  # fmt: skip


@contextmanager
def make_disc(kind: str, folder: Path) -> Iterator[bool]:
    """The folder as a disc of that kind; whether it could be mounted."""
    folder.mkdir(parents=True)
    if not kind:
        yield True
        return
    options = f"size={kind}" if kind.endswith("k") else "size=64k"
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "none", folder], check=False, capture_output=True)
    is_mounted = done.returncode == 0
    try:
        if kind == "read-only":
            if is_mounted:
                subprocess.run(["mount", "-o", "remount,ro", folder], check=True)
            else:
                folder.chmod(0o500)
        elif kind == "full" and is_mounted:
            (folder / FILLER).write_bytes(bytes(65536))
        yield is_mounted
    finally:
        if is_mounted:
            subprocess.run(["umount", "-l", folder], check=True)
        folder.chmod(0o700)


def prepare(around: Surroundings, is_mounted: bool) -> Callable[[], None]:
    """What the process does before it becomes the command."""

    def run() -> None:
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # As a shell starts it.
        if around.disc and around.disc != "read-only" and not is_mounted:
            size = 0 if around.disc == "full" else int(around.disc.removesuffix("k")) * 1024
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        for number in around.closed:
            os.close(number)

    return run


def _open_sink(sink: str, path: Path) -> int:
    """A descriptor to write to."""
    if sink == "pipe":
        reading, writing = os.pipe()
        os.close(reading)
        return writing
    return os.open(sink or path, os.O_WRONLY | (0 if sink else os.O_CREAT | os.O_TRUNC))


def run_command(name: str, what: str, work: Path) -> dict[str, Any]:
    """Run a command in its surroundings and say how it ended."""
    around, room = SURROUNDINGS[what], Path(tempfile.mkdtemp(dir=work))
    out = room / around.name
    takes = work / "takes"
    with make_disc(around.disc, out) as is_mounted:
        if around.name != "out":  # Recordings, too, have such a path.
            takes = Path(shutil.copytree(takes, room / f"{around.name} takes"))
        command = [part.replace("OUT", str(out)).replace("TAKES", str(takes)) for part in COMMANDS[name]]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(work / "site"), *_python_path()])}
        environment |= {key: value for key, value in around.environment.items() if value}
        for key in (key for key, value in around.environment.items() if not value):
            environment.pop(key, None)
        sinks = _open_sink(around.sink, room / "printed"), _open_sink(around.error_sink, room / "messages")
        began = time.monotonic()
        try:
            code: int | None = subprocess.run(
                [sys.executable, "-m", "spiraltrunk", *command], check=False, stdin=subprocess.DEVNULL, cwd=room,
                stdout=sinks[0], stderr=sinks[1], timeout=SECONDS, start_new_session=True, env=environment,
                preexec_fn=prepare(around, is_mounted),
            ).returncode  # fmt: skip
        except subprocess.TimeoutExpired:
            code = None
        finally:
            for number in sinks:
                os.close(number)
        left = sorted(str(path.relative_to(out)) for path in out.rglob("*") if path.is_file() and path.name != FILLER)
        faults = list(find_faults(name, around, code, room, left))
    said = "" if around.error_sink else (room / "messages").read_text(errors="replace")[-2000:]
    shutil.rmtree(room)
    return {
        "command": name, "surroundings": what, "code": code, "faults": faults, "is_mounted": is_mounted,
        "seconds": round(time.monotonic() - began, 1), "left": left[:8], "said": said.splitlines()[-3:],
    }  # fmt: skip


def _python_path() -> list[str]:
    return [part for part in os.environ.get("PYTHONPATH", "").split(os.pathsep) if part]


def find_faults(name: str, around: Surroundings, code: int | None, room: Path, left: Sequence[str]) -> Iterator[str]:
    """What a command does that it must not."""
    writes, is_heard = any("OUT" in part for part in COMMANDS[name]), 2 not in around.closed and not around.error_sink
    right = {"never": {0, 1}, "may": {0, 1, 2}, "writes": {2} if writes else {0, 1}}[around.refused]
    messages = (room / "messages").read_text(errors="replace") if is_heard else ""
    if code not in right:
        yield f"exit {code}, allowed: {sorted(right)}"
    odd = [line for line in messages.splitlines() if not line.startswith("spiraltrunk: ")]
    if odd and not (1 in around.closed and "--help" in COMMANDS[name]):  # Help then goes to standard error.
        yield f"line on standard error: {odd[0][:200]} ... {odd[-1][:200]}"
    errors = [line for line in messages.splitlines() if line.startswith("spiraltrunk: error:")]
    if is_heard and len(errors) != (code == 2):
        yield f"{len(errors)} errors at exit {code}: {errors[:2]}"
    if code == 2 and around.advice and errors and around.advice not in errors[0]:
        yield f"no {around.advice!r} in {errors[0][:300]}"
    if code == 2 and not around.sink and left and name != "survey":
        yield f"files left: {list(left)[:5]}"
    if code in (0, 1) and "--json" in COMMANDS[name] and not around.sink and 1 not in around.closed:
        try:
            json.loads((room / "printed").read_text(), parse_constant=lambda constant: 1 / 0)
        except (ValueError, ZeroDivisionError) as error:
            yield f"no strict JSON: {error}"


def make_work(work: Path) -> None:
    """Write the recordings and the ``sitecustomize``."""
    if not (work / "takes").exists():
        from attack_takes import make_seeds

        make_seeds(work / "takes.part")
        (work / "takes.part").rename(work / "takes")
    (work / "site").mkdir(exist_ok=True)
    (work / "site" / "sitecustomize.py").write_text(HIDE)


def list_commands() -> list[str]:
    """Commands whose verb there is."""
    from spiraltrunk.cli.entry import VERBS

    verbs = {module.__name__.rpartition(".")[2] for module in VERBS}
    return [name for name, arguments in COMMANDS.items() if arguments[0] in verbs]


def format_table(rows: Sequence[dict[str, Any]]) -> str:
    """Runs and faults by surroundings."""
    lines = [f"{'surroundings':<36}{'runs':>6}{'result':>8}{'refused':>9}{'faults':>8}"]
    for what in dict.fromkeys(row["surroundings"] for row in rows):
        own = [row for row in rows if row["surroundings"] == what]
        ended, refused = sum(row["code"] in (0, 1) for row in own), sum(row["code"] == 2 for row in own)
        lines.append(f"{what:<36}{len(own):>6}{ended:>8}{refused:>9}{sum(bool(row['faults']) for row in own):>8}")
    return "\n".join(lines)


def main(argv: list[str] | None = None) -> int:
    """Run, print the table, and return 1 where a run has a fault."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("work", type=Path, help="folder to work in; the same one goes on")
    parser.add_argument("--commands", default="", metavar="NAMES", help="with semicolons (default: all)")
    parser.add_argument("--surroundings", default=";".join(SURROUNDINGS), metavar="NAMES", help="with semicolons")
    arguments = parser.parse_args(argv)
    work = arguments.work.absolute()
    work.mkdir(parents=True, exist_ok=True)
    make_work(work)
    log = work / "runs.jsonl"
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    done = {(row["command"], row["surroundings"]) for row in rows}
    names = arguments.commands.split(";") if arguments.commands else list_commands()
    asked = [(name, what) for what in arguments.surroundings.split(";") for name in names]
    for name, what in asked:
        if (name, what) not in done:
            rows.append(run_command(name, what, work))
            with log.open("a") as file:
                file.write(json.dumps(rows[-1]) + "\n")
            if rows[-1]["faults"]:
                print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
    rows = [row for row in rows if (row["command"], row["surroundings"]) in set(asked)]
    print(format_table(rows))
    return 1 if any(row["faults"] for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
