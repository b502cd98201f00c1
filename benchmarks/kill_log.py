"""Kill a process that writes a log at random moments with SIGKILL, and read what it leaves; measure the log's cost.

Claim (docstring of `spiraltrunk.hardware.log.writer`): every file opens, and what it lacks was written in the last
second. The killed process logs the motors at 500 Hz and arm, command and state at 50 Hz, and reports through a pipe the
number of each tick once `LogWriter.write` has returned; the pipe keeps what was reported before the kill. Lost is the
time from the last tick in the file to the last one reported.

Usage: ``python benchmarks/kill_log.py [--kills 100] [--seed 0] [--chunks 3]``, where parts of so few chunks let kills
come between two parts of a log, and ``--cost`` for the time that logging takes from a
loop at 500 Hz, and the sizes of a log with and without compression.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.design.toml import format_design
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.files.results import read_versions
from spiraltrunk.hardware.arm.arm_port import ArmState
from spiraltrunk.hardware.log import LogMetadata, LogWriter, load_log, part
from spiraltrunk.hardware.log.channels import MotorLog
from spiraltrunk.hardware.log.recording import log_arm, log_motors, log_state
from spiraltrunk.hardware.motors.motor_port import MotorState

PERIOD = 0.002
"""Period of the motors' loop [s]."""

BAR = 1.0
"""Longest time that a kill may lose [s]."""

_TICK = struct.Struct("<qd")


@dataclass(frozen=True, kw_only=True)
class Kill:
    """One kill and what the file still had."""

    after: float
    """Time from the first report to the kill [s]."""
    reported: int
    """Ticks that the process reported."""
    found: int
    """Ticks in the file."""
    lost: float
    """From the last tick in the file to the last that was reported [s]."""
    error: str | None
    """Why the file does not open, if it does not."""

    @property
    def holds(self) -> bool:
        """Whether the file opens and lacks no more than is allowed."""
        return self.error is None and self.lost <= BAR


def build_metadata() -> LogMetadata:
    """Metadata as a driver writes them."""
    return LogMetadata(
        design=format_design(presets.PAPER), bus="virtual", is_twin=True, seed=0, versions=read_versions("numpy"),
        provenance="benchmarks/kill_log.py",
    )  # fmt: skip


Measured = tuple[list[MotorState], ArmState, list[float]]


def measure_tick(now: float, rng: random.Random) -> Measured:
    """What a loop has to log in one tick; numbers are noisy, as measured ones are."""
    states = [
        MotorState(
            time=now - 1e-3, angle=40 * rng.random(), speed=rng.gauss(0, 1), torque=rng.gauss(0, 0.1), temperature=40.0
        )
        for _ in range(3)
    ]
    joints = np.array([rng.random() for _ in range(7)])
    arm = ArmState(time=now, position=joints, velocity=joints, acceleration=joints, torque=joints)
    return states, arm, [rng.random() for _ in range(12)]


def log_tick(log: LogWriter, tick: int, now: float, measured: Measured) -> None:
    """Log one tick of a loop: the motors, and every tenth time arm, state and command."""
    states, arm, values = measured
    log_motors(log, now, states, sent=values[9:], pull=values[:3], tension=values[3:6], target=values[6:9])
    if tick % 10 == 0:
        log_arm(log, arm)
        log_state(log, now, "armed")
        log.write("/command", now, {
            "step": tick // 10, "T_world_base": np.eye(4), "cable_tension": values[:3], "cable_pull": None,
            "gripper": 0.0,
        })  # fmt: skip


def write_until_killed(path: str, seed: int, chunks: int) -> None:
    """Main function of the process that is killed."""
    part.MOST_CHUNKS = chunks
    rng, tick = random.Random(seed), 0
    due = time.monotonic()
    with LogWriter(path, due, build_metadata()) as log:
        while True:
            now = time.monotonic()
            log_tick(log, tick, now, measure_tick(now, rng))
            os.write(1, _TICK.pack(tick, now))
            tick += 1
            due = max(due + PERIOD, now - 1.0)  # A machine that was busy is not made up for in one go.
            time.sleep(max(0.0, due - time.monotonic()))


def kill_once(folder: Path, number: int, after: float, chunks: int) -> Kill:
    """Start the process, kill it ``after`` seconds from its first report on, and read what it leaves."""
    path = folder / f"{number}.mcap"
    command = [sys.executable, __file__, "--write", str(path), "--seed", str(number), "--chunks", str(chunks)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        sent = child.stdout.read(_TICK.size)
        os.set_blocking(child.stdout.fileno(), False)
        end = time.monotonic() + after
        while time.monotonic() < end:
            time.sleep(min(0.005, max(0.0, end - time.monotonic())))
            sent += child.stdout.read() or b""
        child.send_signal(signal.SIGKILL)
        child.wait()
        sent += child.stdout.read() or b""
    reports = list(_TICK.iter_unpack(sent[: len(sent) // _TICK.size * _TICK.size]))
    return _compare(path, after, reports)


def _compare(path: Path, after: float, reports: list[tuple[int, float]]) -> Kill:
    """The kill's outcome; a file without ticks lacks all that was reported."""
    began, ended = reports[0][1], reports[-1][1]
    try:
        times = load_log(path, ["/motors"])[MotorLog].time
    except SpiralTrunkError as error:
        return Kill(after=after, reported=len(reports), found=0, lost=ended - began, error=str(error))
    found = len(times)
    written = np.array([now for _, now in reports[:found]])
    error = None if np.array_equal(times[: len(written)], written) else "ticks differ from those reported"
    lost = max(0.0, ended - (times[-1] if found else began))
    return Kill(after=after, reported=len(reports), found=found, lost=float(lost), error=error)


def kill_often(kills: int, seed: int, longest: float = 3.0, chunks: int = part.MOST_CHUNKS) -> list[Kill]:
    """Kill at moments drawn evenly from 0 to ``longest`` [s]; a twentieth of them in the first 50 ms."""
    rng, done = random.Random(seed), []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(kills):
            after = rng.uniform(0.0, 0.05 if number % 20 == 0 else longest)
            done.append(kill_once(Path(folder), number, after, chunks))
            if sys.stderr.isatty():
                print(f"\r{number + 1} of {kills}", end="", file=sys.stderr)
    return done


def format_table(kills: Sequence[Kill]) -> str:
    """Table of all kills by the time after which they came, and the worst."""
    lines = [f"{'killed after [s]':>18}{'kills':>7}{'open':>6}{'lost p50 [s]':>14}{'lost max [s]':>14}"]
    for low, high in ((0.0, 0.05), (0.05, 0.5), (0.5, 1.0), (1.0, 2.0), (2.0, 3.0), (0.0, 3.0)):
        some = [kill for kill in kills if low <= kill.after < high]
        if some:
            lost = np.array([kill.lost for kill in some])
            opened = sum(kill.error is None for kill in some)
            span = f"{low:g} to {high:g}" if (low, high) != (0.0, 3.0) else "all"
            lines.append(f"{span:>18}{len(some):>7}{opened:>6}{np.median(lost):>14.3f}{lost.max():>14.3f}")
    return "\n".join([*lines, *(f"not opened: {kill.error}" for kill in kills if kill.error)])


def measure_cost(seconds: float) -> dict[str, dict[str, float]]:
    """Cost of logging for a loop at 500 Hz: time of the calls, processor time, and lateness without and with a log."""
    figures: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        figures["lateness without a log [us]"] = _summarise(_run_loop(None, seconds)[1])
        path = Path(folder, "cost.mcap")
        log = LogWriter(path, time.monotonic(), build_metadata())
        used = time.process_time() - time.thread_time()
        calls, late = _run_loop(log, seconds)
        log.close()
        used = time.process_time() - time.thread_time() - used
        figures |= {"calls of a tick [us]": _summarise(calls), "lateness with a log [us]": _summarise(late)}
        figures["thread of the log"] = {"processor time [%]": round(100 * used / seconds, 1), "lost": log.n_lost}
        figures["size"] = _measure_size(path, seconds)
    return figures


def _run_loop(log: LogWriter | None, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Time of the calls of each tick by the processor's clock, and lateness of each tick [s]."""
    rng, calls, late = random.Random(0), [], []
    due = time.monotonic()
    for tick in range(round(seconds / PERIOD)):
        measured = measure_tick(due, rng)
        due += PERIOD
        time.sleep(max(0.0, due - time.monotonic()))
        now = time.monotonic()
        late.append(now - due)
        due = max(due, now - PERIOD)
        began = time.thread_time()
        if log is not None:
            log_tick(log, tick, now, measured)
        calls.append(time.thread_time() - began)
    return np.array(calls), np.array(late)


def _summarise(times: np.ndarray) -> dict[str, float]:
    points = np.percentile(1e6 * times, [50, 99, 99.9, 100])
    return {name: round(float(point), 1) for name, point in zip(("p50", "p99", "p99.9", "max"), points, strict=True)}


def _measure_size(path: Path, seconds: float) -> dict[str, float]:
    """Size of the log for one hour [MB], compressed as it is and as it would be uncompressed."""
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader

    with path.open("rb") as file:
        chunks = [one for one in StreamReader(file, emit_chunks=True).records if isinstance(one, Chunk)]
    hour = 3600 / seconds / 1e6
    plain, packed = (
        hour * sum(sizes) for sizes in zip(*((c.uncompressed_size, len(c.data)) for c in chunks), strict=True)
    )
    return {"none [MB/h]": round(plain), "zstd [MB/h]": round(packed), "chunks": len(chunks)}


def main() -> int:
    """Run what is asked for; 1 where a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--chunks", type=int, default=part.MOST_CHUNKS, help="chunks of a part of the log")
    parser.add_argument("--cost", action="store_true", help="measure the cost instead")
    parser.add_argument("--seconds", type=float, default=20.0, help="length of each loop of --cost")
    parser.add_argument("--write", metavar="FILE", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.write:
        write_until_killed(given.write, given.seed, given.chunks)
    if given.cost:
        print(json.dumps(measure_cost(given.seconds), indent=2))
        return 0
    kills = kill_often(given.kills, given.seed, chunks=given.chunks)
    print(format_table(kills))
    return 0 if all(kill.holds for kill in kills) else 1


if __name__ == "__main__":
    sys.exit(main())
