"""A survey's folder, spoiled field by field, and the survey resumed in it.

Claim (docs/howto/survey.md): the same command resumes a survey, or refuses its folder with one line and changes no
byte of it. ``trials.jsonl`` and ``survey.json`` of an interrupted survey are spoiled: every key is missing or has
another value of `VALUES`, lines are cut, doubled, swapped and invented, bytes change, a file becomes a folder, a link
or a pipe. The trials are instant ones, and no picture is drawn; all else is the command as it is. A survey that goes
on must end complete, with the trials of its plan once each, and numbers where numbers belong.
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import io
import json
import math
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from spiraltrunk import cli
from spiraltrunk.workflows.survey import results, run_survey
from spiraltrunk.workflows.survey.plan import Entry, SurveyPlan
from spiraltrunk.workflows.survey.row import build_empty_row

SECONDS = 20
"""Time that a try may take [s]."""

KEPT = 4
"""Trials in the log of the interrupted survey, of six."""

MISSING = object()
"""Stands for a key that is not there."""

ARGUMENTS = ["survey", "--strategies", "kick,wrap-vertical", "--trials", "3", "--seed", "7", "--workers", "1", "--json"]

VALUES: dict[str, Any] = {
    "missing": MISSING, "null": None, "true": True, "0": 0, "1": 1, "-1": -1, "half": 0.5, "huge": 1e308,
    "huge integer": 10**400, "not a number": math.nan, "infinite": math.inf, "empty text": "", "text": "kick",
    "long text": "a" * 100_000, "control characters": "a\n\0\x1b[31m", "half a surrogate": "\ud800", "list": [],
    "object": {}, "list of itself": [[1], ["a"]], "object in it": {"kick": {"kick": 1}},
}  # fmt: skip
"""What a field becomes, by name; two more are texts, as Python cannot build them: see `spoil_text`."""

DEEP = {"nested 1000 deep": "[" * 1000 + "]" * 1000, "nested 100000 deep": "[" * 100_000 + "]" * 100_000}


def play(entry: Entry) -> dict[str, Any]:
    """An instant trial, decided by its seed."""
    figures = {"lift_m": 0.1, "hold_s": 2.0, "width_m": 0.05, "mass_kg": 0.2, "wall_s": 0.5, "retries": 0}
    row = {**build_empty_row(entry), **figures, "success": entry.seed % 3 > 0}
    return row if row["success"] else {**row, "reason": "not lifted"}


def play_all(work: Callable[[Entry], Any], jobs: Any, workers: int) -> Iterator[SimpleNamespace]:
    """`run_jobs` without processes."""
    for job in jobs:
        yield SimpleNamespace(job=job, result=play(job), fault=None, error=None)


def play_some(work: Callable[[Entry], Any], jobs: Any, workers: int) -> Iterator[SimpleNamespace]:
    """`play_all`, interrupted."""
    for number, outcome in enumerate(play_all(work, jobs, workers)):
        if number == KEPT:
            raise KeyboardInterrupt
        yield outcome


def make_folder(folder: Path) -> None:
    """Write the folder of an interrupted survey."""
    code, _, messages = call([*ARGUMENTS, "--out", str(folder)], play_some)
    if code != 130:
        raise AssertionError(f"exit {code}: {messages}")


class Late(BaseException):
    """A try takes longer than `SECONDS`."""


def _end_late(number: int, frame: object) -> None:
    raise Late(f"not ended after {SECONDS} s")


def call(argv: list[str], jobs: Callable[..., Any]) -> tuple[object, str, str]:
    """Exit code, standard output and standard error of the command."""
    figures = {"write_figure": lambda figure, path, **settings: Path(path).write_bytes(b"PNG")}
    printed, messages = io.StringIO(), io.StringIO()
    signal.signal(signal.SIGALRM, _end_late)
    signal.alarm(SECONDS)
    try:
        with (
            patch.multiple(run_survey, run_jobs=jobs), patch.multiple(results, **figures), warnings.catch_warnings(),
            contextlib.redirect_stdout(printed), contextlib.redirect_stderr(messages),
        ):  # fmt: skip
            warnings.simplefilter("always")
            return cli.main(argv), printed.getvalue(), messages.getvalue()
    except BaseException:
        return traceback.format_exc(limit=-3), printed.getvalue(), messages.getvalue()
    finally:
        signal.alarm(0)


def _paths(value: Any, most: int = 3) -> Iterator[tuple[Any, ...]]:
    """Keys on the way to each field, and to each field in it."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value[:2]) if isinstance(value, list) else ()
    for key, part in pairs:
        yield (key,)
        if most > 1:
            yield from ((key, *more) for more in _paths(part, most - 1))


def spoil(document: Any, path: tuple[Any, ...], value: object) -> str:
    """The document as JSON with another value at a path."""
    changed = copy.deepcopy(document)
    place = changed
    for key in path[:-1]:
        place = place[key]
    if value is MISSING:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return json.dumps(changed)


def list_fields(base: Path) -> list[tuple[str, Callable[[Path], None]]]:
    """A change for every field and value, by its description."""
    rows = [json.loads(line) for line in (base / "trials.jsonl").read_text().splitlines()]
    whole = json.loads((base / "survey.json").read_text())
    changes: list[tuple[str, Callable[[Path], None]]] = []

    def add(what: str, name: str, text: str) -> None:
        changes.append((what, lambda folder: _write(folder / name, text.encode("utf-8", "surrogatepass"))))

    for name in (*VALUES, *DEEP):
        value = VALUES.get(name, "@deep")
        for number in (0, len(rows) - 1):
            for key in rows[number]:
                line = spoil(rows[number], (key,), value).replace('"@deep"', DEEP.get(name, ""))
                lines = [*map(json.dumps, rows[:number]), line, *map(json.dumps, rows[number + 1 :])]
                add(f"row {number}, {key}: {name}", "trials.jsonl", "\n".join(lines) + "\n")
        for path in _paths(whole):
            text = spoil(whole, path, value).replace('"@deep"', DEEP.get(name, ""))
            add(f"survey.json, {path}: {name}", "survey.json", text)
        if value is not MISSING:
            for file in ("trials.jsonl", "survey.json"):
                add(f"all of {file}: {name}", file, DEEP.get(name) or json.dumps(value) + "\n")
    return changes


def _write(path: Path, data: bytes) -> None:
    """The file with other bytes; a new name, as some commands leave files that may not be written."""
    path.unlink(missing_ok=True)
    path.write_bytes(data)


def spoil_at_random(folder: Path, draw: random.Random) -> str:
    """Spoil a file in another way than by its fields."""
    path = folder / draw.choice(("trials.jsonl", "trials.jsonl", "survey.json"))
    data = path.read_bytes()
    lines = data.splitlines(keepends=True)
    at, kind = draw.randrange(len(lines)), draw.choice(tuple(KINDS))
    changed = KINDS[kind](data, lines, at, draw)
    if changed is None:
        path.unlink()
        _put_special(path, draw.choice(("folder", "pipe", "dangling link", "link to a device", "missing")))
    else:
        _write(path, changed)
    return f"{path.name}: {kind}"


def _change_bytes(data: bytes, lines: list[bytes], at: int, draw: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(draw.choice((1, 2, 50))):
        changed[draw.randrange(len(changed))] = draw.choice((draw.randrange(256), 0, 10, 255))
    return bytes(changed)


def _swap(data: bytes, lines: list[bytes], at: int, draw: random.Random) -> bytes:
    other = draw.randrange(len(lines))
    lines[at], lines[other] = lines[other], lines[at]
    return b"".join(lines)


KINDS: dict[str, Callable[[bytes, list[bytes], int, random.Random], bytes | None]] = {
    "bytes": _change_bytes, "swapped lines": _swap,
    "cut": lambda data, lines, at, draw: data[: draw.randrange(len(data))],
    "cut in front": lambda data, lines, at, draw: data[draw.randrange(len(data)) :],
    "line missing": lambda data, lines, at, draw: b"".join(lines[:at] + lines[at + 1 :]),
    "line twice": lambda data, lines, at, draw: b"".join(lines[:at] + [lines[at]] * draw.choice((2, 100)) + lines[at:]),
    "line put in": lambda data, lines, at, draw: b"".join(
        [*lines[:at], draw.choice((b"\n", b"{}\n", b"null\n", b"\xff\xfe\n", b"x" * 10_000_000 + b"\n")), *lines[at:]]
    ),
    "bytes behind": lambda data, lines, at, draw: data + draw.choice((b"{", b"\0" * 4096, b"\n\n", b"\xff", b"a\n")),
    "other line endings": lambda data, lines, at, draw: data.replace(b"\n", draw.choice((b"\r\n", b"\r", b"\x85"))),
    "other encoding": lambda data, lines, at, draw: data.decode("latin-1").encode(
        draw.choice(("utf-16", "utf-32", "utf-8-sig"))
    ),
    "random bytes": lambda data, lines, at, draw: draw.randbytes(draw.choice((0, 1, 300, 100_000))),
    "other file": lambda data, lines, at, draw: None,
}  # fmt: skip
"""Other ways to spoil a file: its new bytes, by its bytes, its lines, a line and the draw; None for no regular file."""


def _put_special(path: Path, kind: str) -> None:
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind != "missing":
        path.symlink_to("/dev/zero" if kind == "link to a device" else "none")


def look(folder: Path) -> dict[str, Any]:
    """Files with their bytes, or what they are."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        if path.is_file() and not path.is_symlink()
        else str(path.lstat().st_mode)
        for path in folder.rglob("*")
    }


def find_faults(folder: Path, before: dict[str, Any], outcome: tuple[object, str, str]) -> Iterator[str]:
    """What a resumed survey does that it must not."""
    code, printed, messages = outcome
    odd = [line for line in messages.splitlines() if not line.startswith("spiraltrunk: ")]
    errors = [line for line in messages.splitlines() if line.startswith("spiraltrunk: error:")]
    if odd:
        yield f"line on standard error: {odd[0][:200]}"
    if code == 2:
        if len(errors) != 1 or len(errors[0]) > 1000:
            yield f"{len(errors)} errors: {errors[:1]}"
        after = look(folder)
        differing = sorted(name for name in before.keys() | after.keys() if before.get(name) != after.get(name))
        if differing:
            yield f"refused, but changed {differing}"
    elif code == 0:
        yield from _check_result(folder, printed)
    else:
        yield f"exit {code}"


def _check_result(folder: Path, printed: str) -> Iterator[str]:
    plan = [dict(vars(entry)) for entry in _plan().entries()]
    try:
        result = json.loads(printed, parse_constant=lambda name: 1 / 0)
        rows = json.loads((folder / "survey.json").read_text(), parse_constant=lambda name: 1 / 0)["rows"]
        lines = [json.loads(line) for line in (folder / "trials.jsonl").read_bytes().splitlines()]
    except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError) as error:
        yield f"ended, but {type(error).__name__}: {str(error)[:200]}"
        return
    if not result["complete"] or sum(own["trials"] for own in result["strategies"].values()) != len(plan):
        yield "ended, but not complete"
    for name, held in (("survey.json", rows), ("trials.jsonl", lines)):
        found = [{key: row.get(key) for key in ("strategy", "object", "index", "seed")} for row in held]
        wrong = [entry for entry in found if entry not in plan]
        if wrong or len(found) != len(plan):
            yield f"ended, but {name} has {len(found)} trials, not of the plan: {str(wrong[:1])[:200]}"
        for row in held:
            kinds = {
                "strategy": str, "object": str, "reason": str, "cause": str, "index": int, "seed": int,
                "success": bool, "held": bool, "upright": bool,
            }  # fmt: skip
            for key, value in row.items():
                kind = kinds.get(key, (int, float))
                if value is not None and (
                    not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool)
                ):
                    yield f"ended, but {name} has {key} {str(value)[:80]!r}"


def _plan() -> SurveyPlan:
    from spiraltrunk import strategies

    objects = {name: strategies.get(name).objects for name in ("kick", "wrap-vertical")}
    return SurveyPlan(objects=objects, trials=3, seed=7)


def run(count: int, seconds: float, seed: int) -> dict[str, Any]:
    """Resume spoiled surveys: first every field in a drawn order, then others, until there are so many."""
    faults: list[str] = []
    outcomes, slowest, began, tries = Counter[str](), 0.0, time.monotonic(), 0
    with tempfile.TemporaryDirectory() as made:
        base = Path(made) / "base"
        make_folder(base)
        fields = list_fields(base)
        random.Random(seed).shuffle(fields)
        for number in range(count):
            if time.monotonic() - began > seconds:
                break
            folder = Path(shutil.copytree(base, Path(made) / "try"))
            if number % 2 == 0 and number // 2 < len(fields):
                what, change = fields[number // 2]
                change(folder)
            else:
                what = spoil_at_random(folder, random.Random(f"{seed} {number}"))
            before, start = look(folder), time.perf_counter()
            outcome = call([*ARGUMENTS, "--out", str(folder)], play_all)
            slowest = max(slowest, time.perf_counter() - start)
            found = list(find_faults(folder, before, outcome))
            if found:
                faults.append(f"try {number}, {what}: {'; '.join(found)}")
                print(faults[-1][:1500], file=sys.stderr, flush=True)
            outcomes[{0: "went on", 2: "refused"}.get(outcome[0], "other") if not found else "fault"] += 1  # type: ignore[call-overload]
            shutil.rmtree(folder)
            tries += 1
    return {
        "tries": tries, "fields and values": len(fields), "outcomes": dict(outcomes), "faults": len(faults),
        "slowest_s": round(slowest, 2), "seconds": round(time.monotonic() - began),
    }  # fmt: skip


def main(argv: list[str] | None = None) -> int:
    """Run and print the figures as JSON; 1 where a try has a fault."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=10_000, help="tries (default 10000)")
    parser.add_argument("--seconds", type=float, default=1e9, help="time after which it ends (default: none)")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args(argv)
    found = run(arguments.count, arguments.seconds, arguments.seed)
    print(json.dumps(found, indent=2))
    return 1 if found["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
