"""Interrupt every command at random moments with INT, TERM, HUP and KILL, and look at what stays.

Claim (docs/howto/read_results.md): an interrupted command ends with the signal's exit code and at most its own lines on
standard error, leaves no process behind, and the same command then works and leaves the same files as if it had never
been interrupted.

A round interrupts one command a few times in one folder and then runs it to its end there. Rounds are appended to
``rounds.jsonl`` in the work folder; the same call goes on after the last. No check depends on the machine's speed:
limits of time are far above what is needed.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import secrets
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

MARK = "SPIRALTRUNK_ATTACK"
"""Variable by which the processes of a command are found."""

TAKES = [f"../takes/{run}_{k}.csv" for run in ("rest-000", "bend-dorsal", "twist") for k in (1, 2)]
PROTOCOL = ["--protocol", "../takes/protocol.toml", "--axes", "y-up"]
DEMOS = ["demos", "kick", "--trials", "2", "--workers", "2"]
SURVEY = ["survey", "--strategies", "kick", "--trials", "2", "--workers", "2"]

COMMANDS = {
    "design": ["design", "--out", "OUT/trunk.toml"],
    "shape": ["shape", "--model", "statics", "--cables-mm", "30", "0", "0"],
    "shape --plot": ["shape", "--dorsal-mm", "30", "--plot", "OUT/shape.png"],
    "grasp": ["grasp", "--out", "OUT"],
    "grasp kick": ["grasp", "kick", "--out", "OUT"],
    "grasp --no-video": ["grasp", "--no-video", "--out", "OUT"],
    "survey": [*SURVEY, "--out", "OUT"],
    "validate": ["validate", *TAKES[::2], *PROTOCOL, "--out", "OUT"],
    "calibrate": ["calibrate", *TAKES, *PROTOCOL, "--out", "OUT"],
    "calibrate --virtual": ["calibrate", "--virtual", "OUT"],
    "export": ["export", "--parts", "horn", "--formats", "stl", "step", "mjcf", "urdf", "--out", "OUT"],
    "export, processes": ["export", "--parts", "gripper", "housing", "--formats", "stl", "--out", "OUT"],
    "bench": ["bench", "--out", "OUT"],
    "object": ["object", "bottle-70", "--plot", "OUT/object.png"],
    "grasp auto": ["grasp", "auto", "--object", "cube-28", "--no-video", "--out", "OUT"],
    "demos": [*DEMOS, "--format", "robomimic", "--out", "OUT"],
    "demos lerobot": [*DEMOS, "--format", "lerobot", "--out", "OUT"],
    "optimize": ["optimize", "--trials", "1", "--objects", "2", "--unseen", "1", "--workers", "2", "--out", "OUT"],
    "drive pull": ["drive", "pull", "20", "0", "0"],
    "drive run": ["drive", "run", "kick", "--out", "OUT"],
}
"""Arguments of each command; OUT is the folder of the round."""

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)

TRACES = ("Traceback", "SystemError", "Segmentation", "Aborted", "npickl", "resource_tracker", "Exception ignored")
"""Parts of messages that a user must never see after an interruption."""

EARLY = 2.0
"""First part of a command in which half of the moments lie [s]."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Times that nothing may exceed [s]."""

    run: float = 1200.0
    """A command that is not interrupted."""
    end: float = 60.0
    """From a signal to the end of the process."""
    processes: float = 5.0
    """From the end of the process to that of all its processes."""


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """One interruption, or, where `number` is 0, a run to the end."""

    command: str
    number: int
    moment: float
    is_group: bool
    """Whether the signal goes to the whole process group, as a terminal sends it."""
    code: int
    late: float
    """Time from the signal to the end of the process [s]."""
    ended: str
    """How it ended: interrupted, finished (before the signal), outside (Python itself began or ended) or to the end."""
    faults: tuple[str, ...]


class Running:
    """A command that runs in a session of its own, with its messages in files."""

    def __init__(self, arguments: Sequence[str], out: Path) -> None:
        work = out.parent
        self.token = secrets.token_hex(8)
        self.messages, self.printed = work / f"{out.name}.err", work / f"{out.name}.out"
        command = [sys.executable, "-m", "spiraltrunk", *(part.replace("OUT", str(out)) for part in arguments)]
        path = [str(Path(part).absolute()) for part in os.environ.get("PYTHONPATH", "").split(os.pathsep) if part]
        environment = os.environ | {MARK: self.token, "PYTHONPATH": os.pathsep.join(path)}
        with self.messages.open("wb") as messages, self.printed.open("wb") as printed:
            self.process = subprocess.Popen(
                command, cwd=work, env=environment, stdin=subprocess.DEVNULL, stdout=printed, stderr=messages,
                start_new_session=True,
            )  # fmt: skip

    def wait(self, limit: float) -> int | None:
        """Exit code, or None where the process has not ended within the limit."""
        try:
            return self.process.wait(limit)
        except subprocess.TimeoutExpired:
            return None

    def send(self, number: int, *, is_group: bool) -> None:
        """Send the signal to the process or to all of its group."""
        with suppress(ProcessLookupError):
            (os.killpg if is_group else os.kill)(self.process.pid, number)

    def find_processes(self) -> list[int]:
        """All living processes of the command."""
        mark = f"{MARK}={self.token}".encode()
        return [number for number in _list_processes() if mark in _read(f"/proc/{number}/environ").split(b"\0")]

    def hears(self) -> bool:
        """Whether the command's own handler of signals is installed."""
        for line in _read(f"/proc/{self.process.pid}/status").splitlines():
            if line.startswith(b"SigCgt:"):
                return bool(int(line.split()[1], 16) >> (signal.SIGTERM - 1) & 1)
        return False

    def kill_all(self) -> None:
        """End what is left, so that it does not disturb later rounds."""
        for number in self.find_processes():
            with suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
        self.process.wait()


def _list_processes() -> list[int]:
    return [int(path.name) for path in Path("/proc").iterdir() if path.name.isdecimal()]


def _read(path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError:  # It has ended.
        return b""


def list_files(out: Path) -> set[str]:
    """Files and empty folders below a folder."""
    return {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file() or not any(path.iterdir())}


def run_to_end(name: str, out: Path, limits: Limits) -> tuple[int | None, float, str]:
    """Exit code, duration [s] and messages of a command that is not interrupted."""
    began, running = time.monotonic(), Running(COMMANDS[name], out)
    try:
        code = running.wait(limits.run)
    finally:
        running.kill_all()
    return code, time.monotonic() - began, running.messages.read_text(errors="replace")


def interrupt(name: str, draw: random.Random, duration: float, out: Path, limits: Limits) -> Attempt:
    """Start the command, interrupt it and look at what it leaves."""
    moment = draw.uniform(0.0, min(EARLY, duration) if draw.random() < 0.5 else duration)
    number, is_group = draw.choice(SIGNALS), draw.random() < 0.5
    running = Running(COMMANDS[name], out)
    try:
        code = running.wait(moment)
        heard, has_printed = running.hears(), running.printed.stat().st_size > 0
        sent = time.monotonic()
        ended = "finished" if code is not None else "interrupted" if heard else "outside"
        if code is None:
            running.send(number, is_group=is_group)
            code = running.wait(limits.end)
        late = time.monotonic() - sent
        faults = list(_find_faults(running, code, number, ended, has_printed=has_printed))
        left = _wait_for_processes(running, limits.processes)
    finally:
        running.kill_all()
    faults += [f"{len(left)} processes left"] if left else []
    return Attempt(
        command=name, number=number, moment=round(moment, 3), is_group=is_group, code=-999 if code is None else code,
        late=round(late, 2), ended=ended, faults=tuple(faults),
    )  # fmt: skip


def _find_faults(running: Running, code: int | None, number: int, ended: str, *, has_printed: bool) -> Sequence[str]:
    messages = running.messages.read_text(errors="replace")
    if code is None:
        return [f"did not end; {messages[-300:]}"]
    faults = []
    if ended == "outside" and code in (-number, 128 + number, 1):
        return []  # Python itself was interrupted, which prints what it likes.
    if ended == "interrupted" and number == signal.SIGKILL and code != -number:
        faults.append(f"exit {code}")
    elif ended == "interrupted" and code not in (128 + number, -number) and not has_printed:
        faults.append(f"exit {code} instead of {128 + number}")
    if any(trace in messages for trace in TRACES):
        faults.append(f"messages: {messages[-600:]}")
    odd = [line for line in messages.splitlines() if not line.startswith("spiraltrunk: ")]
    if odd and not faults:
        faults.append(f"line: {odd[0][:200]}")
    return faults


def _wait_for_processes(running: Running, limit: float) -> list[int]:
    end = time.monotonic() + limit
    while (left := running.find_processes()) and time.monotonic() < end:
        time.sleep(0.1)
    return left


def run_round(index: int, baseline: dict[str, Any], work: Path, arguments: argparse.Namespace) -> list[Attempt]:
    """Interruptions of one command in one folder, then, unless they lie within a given time, a run to the end."""
    draw, names = random.Random(f"{arguments.seed} {index}"), list(baseline)
    name, limits = names[index % len(names)], Limits()
    expected = baseline[name]
    with tempfile.TemporaryDirectory(dir=work) as made:
        out = Path(made) / "out"
        attempts = [interrupt(name, draw, expected["duration"], _place(out), limits) for _ in range(arguments.attempts)]
        if arguments.within is not None:
            return attempts
        code, duration, messages = run_to_end(name, _place(out), limits)
        faults = []
        if code != expected["code"]:
            faults.append(f"afterwards exit {code}: {messages[-400:]}")
        elif (files := list_files(out)) != set(expected["files"]):
            faults.append(f"files differ: {sorted(files ^ set(expected['files']))}")
    last = Attempt(
        command=name, number=0, moment=0.0, is_group=False, code=-999 if code is None else code,
        late=round(duration, 2), ended="to the end", faults=tuple(faults),
    )  # fmt: skip
    return [*attempts, last]


def _place(out: Path) -> Path:
    """The folder, made; a command may have removed it as it ended."""
    out.mkdir(exist_ok=True)
    return out


def measure_baseline(names: Sequence[str], work: Path) -> dict[str, Any]:
    """Exit code, duration [s] and files of each command by itself; known ones are kept."""
    path = work / "baseline.json"
    known = json.loads(path.read_text()) if path.exists() else {}
    if {"validate", "calibrate"} & set(names) and not (work / "takes").exists():
        code, _, messages = run_to_end("calibrate --virtual", _place(work / "takes"), Limits())
        if code != 0:
            raise SystemExit(f"no takes: {messages}")
    for name in names:
        if name not in known:
            with tempfile.TemporaryDirectory(dir=work) as made:
                out = _place(Path(made) / "out")
                code, duration, messages = run_to_end(name, out, Limits())
                known[name] = {"code": code, "duration": duration, "files": sorted(list_files(out))}
            if code not in (0, 1):
                raise SystemExit(f"{name} fails by itself: {messages}")
            path.write_text(json.dumps(known, indent=1))
    return {name: known[name] for name in names}


def format_table(rows: Sequence[dict[str, Any]]) -> str:
    """Interruptions and faults by command and signal."""
    count: Counter[tuple[str, int]] = Counter((row["command"], row["number"]) for row in rows)
    bad: Counter[tuple[str, int]] = Counter((row["command"], row["number"]) for row in rows if row["faults"])
    columns = {"INT": 2, "TERM": 15, "HUP": 1, "KILL": 9, "to the end": 0}
    lines = [f"{'faults of interruptions':<24}" + "".join(f"{title:>12}" for title in columns)]
    for name in dict.fromkeys(row["command"] for row in rows):
        cells = [f"{bad[name, number]} of {count[name, number]}" for number in columns.values()]
        lines.append(f"{name:<24}" + "".join(f"{cell:>12}" for cell in cells))
    shot = [row for row in rows if row["number"]]
    ended = Counter(row["ended"] for row in shot)
    lines.append(f"{len(shot)} interruptions ({', '.join(f'{n} {how}' for how, n in ended.items())})")
    waits = sorted(row["late"] for row in shot if row["ended"] == "interrupted")
    if waits:
        lines.append(f"ended after: median {waits[len(waits) // 2]:.2f} s, longest {waits[-1]:.2f} s")
    return "\n".join(lines)


def main(argv: Sequence[str] | None = None) -> int:
    """Run rounds, print the table, and return 1 where anything stayed."""
    for number in SIGNALS[:3]:  # Commands inherit what is ignored, as in the background and under nohup.
        if signal.getsignal(number) == signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("work", type=Path, help="folder to work in; the same one goes on")
    parser.add_argument("--commands", default=";".join(COMMANDS), metavar="NAMES", help="with semicolons")
    parser.add_argument("--rounds", type=int, default=60, help="rounds in all (default 60)")
    parser.add_argument("--attempts", type=int, default=5, help="interruptions of a round (default 5)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--within", type=float, metavar="S", help="interrupt within S seconds; commands are never run to their end"
    )
    arguments = parser.parse_args(argv)
    work = arguments.work.absolute()
    work.mkdir(parents=True, exist_ok=True)
    names = arguments.commands.split(";")
    if arguments.within is None:
        baseline = measure_baseline(names, work)
    else:
        baseline = {name: {"duration": arguments.within} for name in names}
    log = work / "rounds.jsonl"
    done = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    for index in range(len(done), arguments.rounds):
        attempts = [asdict(attempt) for attempt in run_round(index, baseline, work, arguments)]
        done.append(attempts)
        with log.open("a") as file:
            file.write(json.dumps(attempts) + "\n")
        for attempt in attempts:
            if attempt["faults"]:
                print(json.dumps(attempt), flush=True)
    rows = [attempt for attempts in done for attempt in attempts]
    print(format_table(rows))
    return 1 if any(row["faults"] for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
