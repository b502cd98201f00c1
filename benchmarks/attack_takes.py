"""Hostile recordings given to ``validate`` and ``calibrate``, as the command line gets them.

Claim: whatever a file of a recording, a bench or a protocol holds, the command ends in time and memory with exit 0, 1
or 2, at most one line of error, strict JSON without a number that is not finite, and files below ``--out`` alone. Small
sound files are changed at random by the attacks of `CSV`, `C3D` and `TEXT`, one to three a try. Try N of a seed depends
on these two numbers alone: ``--only N`` repeats it. A process does the tries one after the other; where it dies or is
late, that is a fault of the try, and a new one goes on. The process that reads a C3D file is forked from one that has
imported ezc3d (`forked_reader`); ``--fresh`` starts one for each file, as the command itself does.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import resource
import select
import shutil
import subprocess
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from forked_reader import ForkedReader
from take_changes import ATTACKS

SECONDS, MEGABYTES = 60.0, 1500.0
"""Time [s] and memory above what the process had before [MB] that a try may take."""

ADDRESS_SPACE = 16 << 30
"""Limit that keeps the machine alive [bytes]."""

LINE = 1000
"""Longest line on standard error [characters]."""

PROTOCOL = """
schema = 1
name = "short"
axes = "y-up"
alignment = "run"
[[run]]
name = "rest-045"
kind = "rest"
tilt_deg = 45
[[run]]
name = "bend"
kind = "bend-dorsal"
tilt_deg = 0
steps = 2
step_mm = 20
takes = 2
"""

BENCH = "joint,lever_arm_m,mass_g,angle_deg\n" + "".join(
    f"3,0.05,{mass},{angle}\n" for mass, angle in ((0, 0), (5, 4), (10, 8.1), (15, 12.1), (20, 16))
)

OPTIONS = {
    "validate": ([], [], [], ["--alignment", "base"], ["--alignment", "shape"], ["--rotations", "ignore"],
                 ["--axes", "z-up"], ["--alignment", "run:2-5"], ["--axes=x,-z,y"]),
    "calibrate": ([], [], ["--mass-g", "190"], ["--axes", "x-up"]),
}  # fmt: skip


class Attack(NamedTuple):
    """What is attacked."""

    seed: int
    verb: str
    kind: str


def make_seeds(folder: Path) -> None:
    """Write the sound files: two takes of two runs as CSV, one of them as C3D, a bench and a protocol."""
    from spiraltrunk.design.presets import PAPER
    from spiraltrunk.mocap import load_protocol
    from spiraltrunk.mocap.protocol.schedule import build_schedule
    from spiraltrunk.mocap.recordings.motive_write import write_motive
    from spiraltrunk.mocap.session.prediction import predict
    from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions, build_synthetic_take

    folder.mkdir(parents=True)
    (folder / "protocol.toml").write_text(PROTOCOL)
    (folder / "bench.csv").write_text(BENCH)
    protocol = load_protocol(folder / "protocol.toml")
    for run in protocol.runs:
        found = predict(PAPER, build_schedule(PAPER, protocol, run))
        for number in (1, 2):
            options = CameraOptions(rate=20.0, hold=0.8, move=0.3, noise=5e-5, sections=(2, 5, 8, 11), seed=number)
            take = build_synthetic_take(PAPER, found.points, found.rotation, run.theta_0, options)
            write_motive(take, folder / f"{run.name}_{number}.csv")
            _write_c3d(take, folder / f"{run.name}_{number}.c3d")


def _write_c3d(take: Any, path: Path) -> None:
    import ezc3d  # type: ignore[import-untyped]
    import numpy as np

    markers, content = take.markers, ezc3d.c3d()
    point = content["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"] = [take.rate], ["mm"]
    point["LABELS"]["value"] = [marker.name for marker in markers]
    shaped = np.ones((4, len(markers), len(take.frame)))
    shaped[:3] = 1e3 * np.array([marker.position for marker in markers]).transpose(2, 0, 1)
    content["data"]["points"] = shaped
    content.write(str(path))


def draw_try(number: int, attack: Attack, seeds: Path, folder: Path) -> tuple[list[str], list[str]]:
    """Write the files of one try; return the command's arguments and the attacks."""
    seed, verb, kind = attack
    draw = random.Random(f"{seed} {verb} {kind} {number}")
    run = draw.choice(("rest-045", "rest-045", "bend")) if verb == "validate" else "rest-045"
    ending = "c3d" if kind == "c3d" else "csv"
    sources = {
        "csv": [f"{run}_1.csv"], "c3d": [f"{run}_1.c3d"], "bench": ["bench.csv"], "protocol": ["protocol.toml"],
    }[kind]  # fmt: skip
    takes = [] if kind == "bench" else [f"{run}_1.{ending}", *([f"{run}_2.{ending}"] if draw.random() < 0.3 else [])]
    if kind in ("csv", "c3d") and len(takes) == 2 and draw.random() < 0.3:
        sources = takes
    used: list[str] = []
    for name in dict.fromkeys((*takes, "protocol.toml", *sources)):
        data = (seeds / name).read_bytes()
        if name in sources:
            for change in draw.sample(list(ATTACKS[kind]), draw.choice((1, 1, 1, 2, 3))):
                used.append(change)
                data = ATTACKS[kind][change](data, draw) if data else data
        (folder / name).write_bytes(data)
    argv = [verb, *(str(folder / name) for name in takes), "--json"]
    if kind == "bench":
        argv += ["--bench", str(folder / "bench.csv")]
    else:
        argv += ["--protocol", str(folder / "protocol.toml"), *draw.choice(OPTIONS[verb])]
    if draw.random() < 0.1:
        argv += ["--out", str(folder / "out")]
    return argv, used


def find_faults(code: object, printed: str, messages: str, folder: Path, before: set[str]) -> Iterator[str]:
    """What a try does that it must not."""
    if code not in (0, 1, 2):
        yield f"exit {code}"
    lines = messages.splitlines()
    odd = [line for line in lines if not line.startswith("spiraltrunk: ")]
    if odd:
        yield f"line on standard error: {odd[0][:300]} ... {odd[-1][:300]}"
    errors = [line for line in lines if line.startswith("spiraltrunk: error:")]
    if len(errors) != (code in (1, 2)):
        yield f"{len(errors)} errors at exit {code}"
    if any(len(line) > LINE for line in lines):
        yield "a line is too long"
    left = {str(path.relative_to(folder)) for path in folder.rglob("*")} - before
    if code == 0:
        left = {name for name in left if name.split("/")[0] != "out"}
        yield from _check_json(printed)
        if (folder / "out" / "result.json").exists():
            yield from _check_json((folder / "out" / "result.json").read_text())
    elif printed:
        yield f"standard output: {printed[:200]}"
    if left:
        yield f"files left: {sorted(left)[:5]}"


def _check_json(text: str) -> Iterator[str]:
    def refuse(name: str) -> None:
        raise ValueError(f"{name} in JSON")

    try:
        json.loads(text, parse_constant=refuse)
    except ValueError as error:
        yield f"no strict JSON: {error}"


def _read_peak() -> float:
    """Largest resident memory since it was reset [MB]."""
    status = Path("/proc/self/status").read_text()
    return int(re.findall(r"VmHWM:\s+(\d+)", status)[0]) / 1024


def serve(seeds: Path, folder: Path, attack: Attack, *, is_fresh: bool) -> None:
    """Do the tries whose numbers come on standard input, each answered by a line of JSON."""
    answers = os.fdopen(os.dup(1), "w")
    printed, messages = (folder.parent / f"{folder.name}.{ending}" for ending in ("out", "err"))
    for path, number in ((printed, 1), (messages, 2)):
        os.dup2(os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND), number)
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    from spiraltrunk import cli
    from spiraltrunk.mocap.recordings import c3d

    if attack.kind == "c3d" and not is_fresh:
        c3d.run_limited = ForkedReader().run
    warnings.simplefilter("always")
    for line in sys.stdin:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        argv, attacks = draw_try(int(line), attack, seeds, folder)
        before = {str(path.relative_to(folder)) for path in folder.rglob("*")}
        os.truncate(printed, 0)
        os.truncate(messages, 0)
        Path("/proc/self/clear_refs").write_text("5")
        memory, began = _read_peak(), time.perf_counter()
        try:
            code: object = cli.main(argv)
        except BaseException:
            code = "".join(traceback.format_exc().splitlines(keepends=True)[-6:])
        spent, grown = time.perf_counter() - began, _read_peak() - memory
        sys.stdout.flush()
        said = messages.read_text(errors="replace")
        faults = list(find_faults(code, printed.read_text(), said, folder, before))
        faults += [f"{grown:.0f} MB of memory"] if grown > MEGABYTES else []
        answer = {
            "code": code if isinstance(code, int) else -1, "attacks": attacks, "faults": faults, "seconds": spent,
            "megabytes": grown, "argv": argv, "said": said.splitlines()[-1:] and said.splitlines()[-1][-160:],
        }  # fmt: skip
        print(json.dumps(answer), file=answers, flush=True)


class Server:
    """The process that does the tries; it is started anew after a fault."""

    def __init__(self, arguments: argparse.Namespace, work: Path) -> None:
        self.command = [sys.executable, __file__, "--serve", "--work", str(work), "--seed", str(arguments.seed),
                        "--verb", arguments.verb, "--kind", arguments.kind,
                        *(["--fresh"] if arguments.fresh else [])]  # fmt: skip
        self.process: subprocess.Popen[str] | None = None

    def ask(self, number: int, limit: float) -> dict[str, Any]:
        """Outcome of a try; the death of the process, or its being late, is one."""
        if self.process is None:
            self.process = subprocess.Popen(
                self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
            )
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(number, file=self.process.stdin, flush=True)
        line, began = "", time.monotonic()
        if select.select([self.process.stdout], [], [], limit)[0]:
            line = self.process.stdout.readline()
        if line:
            answer: dict[str, Any] = json.loads(line)
            return answer
        late = time.monotonic() - began >= limit
        code = self.stop()
        fault = f"not ended after {limit:g} s" if late else f"the process died: exit {code}"
        return {
            "code": -1,
            "attacks": [],
            "faults": [fault],
            "seconds": limit,
            "megabytes": 0.0,
            "argv": [],
            "said": "",
        }

    def stop(self) -> int | None:
        """End the process."""
        if self.process is None:
            return None
        with suppress(subprocess.TimeoutExpired):  # Where it has died, its own exit code is known soon.
            self.process.wait(0.5)
        self.process.kill()
        code = self.process.wait()
        self.process = None
        return code


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Do the tries that are not yet in the log of the work folder, and sum all up."""
    work = arguments.work.absolute()
    work.mkdir(parents=True, exist_ok=True)
    if not (work / "seeds").exists():
        make_seeds(work / "seeds.part")
        (work / "seeds.part").rename(work / "seeds")
    log = work / f"{arguments.verb}_{arguments.kind}_{arguments.seed}.jsonl"
    rows = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    server, began = Server(arguments, work), time.monotonic()
    numbers = range(len(rows), arguments.count) if arguments.only is None else [arguments.only]
    try:
        for number in numbers:
            if time.monotonic() - began > arguments.seconds:
                break
            # The first try of a process also compiles kernels.
            limit = SECONDS if server.process is not None else 4 * SECONDS
            row = {"number": number, **server.ask(number, limit)}
            if row["faults"]:
                print(json.dumps(row), file=sys.stderr, flush=True)
            if arguments.only is None:
                with log.open("a") as file:
                    file.write(json.dumps({key: row[key] for key in row if key != "argv"}) + "\n")
            rows.append(row)
    finally:
        server.stop()
    attacks, codes = Counter[str](), Counter[str]()
    for row in rows:
        attacks.update(row["attacks"])
        codes[str(row["code"])] += 1
    return {
        "verb": arguments.verb, "kind": arguments.kind, "seed": arguments.seed, "tries": len(rows),
        "exit": dict(sorted(codes.items())), "faults": sum(bool(row["faults"]) for row in rows),
        "attacks": dict(sorted(attacks.items())),
        "slowest_s": round(max((row["seconds"] for row in rows), default=0), 2),
        "most_megabytes": round(max((row["megabytes"] for row in rows), default=0)),
    }  # fmt: skip


def main(argv: list[str] | None = None) -> int:
    """Run and print the figures as JSON; 1 where a try has a fault."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--verb", choices=tuple(OPTIONS), default="validate")
    parser.add_argument("--kind", choices=tuple(ATTACKS), default="csv", help="the file that is changed")
    parser.add_argument("--work", type=Path, required=True, help="folder to work in; the same one goes on")
    parser.add_argument("--count", type=int, default=10_000, help="tries in all (default 10000)")
    parser.add_argument("--seconds", type=float, default=1e9, help="time after which it ends (default: none)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", type=int, metavar="N", help="do this try alone")
    parser.add_argument("--fresh", action="store_true", help="start Python anew for each C3D file: slower")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args(argv)
    if arguments.kind == "bench" and arguments.verb != "calibrate":
        parser.error("--kind bench: allowed with --verb calibrate")
    if arguments.serve:
        folder = arguments.work / f"try_{os.getpid()}"
        attack = Attack(arguments.seed, arguments.verb, arguments.kind)
        serve(arguments.work / "seeds", folder, attack, is_fresh=arguments.fresh)
        return 0
    found = run(arguments)
    print(json.dumps(found, indent=2))
    return 1 if found["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
