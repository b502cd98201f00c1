"""Every equilibrium ends: 100,000 drawn pulls, tilts and loads converge to 1e-8 N m, some thousands with friction too.

Trials are drawn by number, so any can be drawn again. What ended is kept as it ends, and the next run goes on from
there. Exits with 1 where a number is not finite or too few converge, and with 130 when interrupted.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from spiraltrunk.design.presets import PAPER
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.model.statics.kernels import STAMP

RESIDUAL = 1e-8
"""Largest moment left at a joint of what counts as converged [N m]."""

EXCESS = 1e-9
"""Largest error of the length of a cable that its winder holds [m]."""

BAR = {0.0: 1.0}
"""Least share that must converge, by friction [-]; `BAR_FRICTION` for all others."""

BAR_FRICTION = 0.99

CHUNK = 100
"""Trials that are solved and written together."""

STATUSES = tuple(status.name for status in Status)

Chunk = tuple[float, int, int]
"""Friction, first trial, and the trial after the last."""


def draw_case(mu: float, trial: int) -> dict[str, Any]:
    """Any tilt, roll, pulls on any subset of the cables, and a load at any section, for `statics.solve`."""
    rng = np.random.default_rng([5, trial])
    pulled = rng.integers(2**PAPER.n_cable) >> np.arange(PAPER.n_cable) & 1 == 1
    pull = np.where(pulled, rng.uniform(0.0, 0.130, PAPER.n_cable), -PAPER.cable_stroke)
    mass = float(rng.uniform(0.0, 1.0)) if rng.random() < 0.75 else 0.0
    return {
        "pull": pull.tolist(),
        "theta_0": math.pi / 2 - float(rng.uniform(0.0, math.pi)),
        "roll": float(rng.uniform(-math.pi, math.pi)),
        "loads": {"mass": mass, "section": int(rng.integers(PAPER.n_section))},
        "friction": mu,
    }


def solve_case(case: dict[str, Any]) -> Shape:
    """The equilibrium of a drawn case."""
    return statics.solve(PAPER, **case | {"loads": statics.Loads(**case["loads"])})


def judge(case: dict[str, Any], shape: Shape) -> dict[str, Any]:
    """What can be seen of a solution from outside: whether all is finite, its residual, its cables' lengths."""
    forces = shape.forces
    assert forces is not None
    arrays = [shape.points, shape.joint_rotation, shape.gap, *vars(forces).values()]
    pull, tension = np.array(case["pull"]), forces.cable_tension
    holds = (tension > 0) & (tension < PAPER.cable.tension_max)
    return {
        "status": STATUSES[int(shape.status)],
        "is_finite": all(bool(np.isfinite(array).all()) for array in arrays),
        "residual": float(forces.residual),
        "excess": float(np.abs(shape.cable_change - pull)[holds].max(initial=0.0)),
        "bend": float(shape.joint_angle.max()),
    }


def run_chunk(chunk: Chunk) -> dict[str, Any]:
    """Solve a chunk's trials one by one; counts, worst figures, times, and the cases that did not converge."""
    mu, first, last = chunk
    out: dict[str, Any] = {"friction": mu, "first": first, "last": last, "status": dict.fromkeys(STATUSES, 0)}
    out |= {"worst_residual_nm": 0.0, "worst_excess_m": 0.0, "not_finite": 0, "ms": [], "failed": []}
    for trial in range(first, last):
        case = draw_case(mu, trial)
        began = time.perf_counter()
        shape = solve_case(case)
        out["ms"].append(round(1e3 * (time.perf_counter() - began), 3))
        seen = judge(case, shape)
        out["status"][seen["status"]] += 1
        out["not_finite"] += not seen["is_finite"]
        out["worst_residual_nm"] = max(out["worst_residual_nm"], seen["residual"])
        out["worst_excess_m"] = max(out["worst_excess_m"], seen["excess"])
        if not is_good(seen):
            out["failed"].append({"trial": trial, **seen, "case": case})
    return out


def is_good(seen: dict[str, Any]) -> bool:
    """Whether a solution holds what it says."""
    is_within = seen["bend"] <= PAPER.joint_limit * (1 + 1e-12)
    holds = seen["status"] != Status.NOT_CONVERGED.name and seen["excess"] <= EXCESS
    return seen["is_finite"] and holds and is_within and seen["residual"] <= RESIDUAL


def summarise(chunks: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The chunks of one friction added up."""
    ms = np.concatenate([chunk["ms"] for chunk in chunks])
    failed = [case for chunk in chunks for case in chunk["failed"]]
    return {
        "trials": len(ms),
        "converged": 1 - len(failed) / len(ms),
        "status": {name: sum(chunk["status"][name] for chunk in chunks) for name in STATUSES},
        "not_finite": sum(chunk["not_finite"] for chunk in chunks),
        "worst_residual_nm": max(chunk["worst_residual_nm"] for chunk in chunks),
        "worst_excess_m": max(chunk["worst_excess_m"] for chunk in chunks),
        "ms": {f"p{part:g}": float(np.percentile(ms, part)) for part in (5, 50, 95, 99, 99.9, 100)},
        "failed": [case["trial"] for case in failed],
    }


def run_chunks(chunks: Sequence[Chunk], workers: int) -> Iterator[dict[str, Any]]:
    """Chunks as they end."""
    if workers <= 1:
        yield from map(run_chunk, chunks)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(workers, len(chunks) or 1), mp_context=context, initializer=_ignore_interrupt)
    try:
        for job in as_completed([pool.submit(run_chunk, chunk) for chunk in chunks]):
            yield job.result()
    finally:
        _stop(pool)


def _ignore_interrupt() -> None:
    """Ctrl-C reaches every process of the terminal; the first one alone answers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _stop(pool: ProcessPoolExecutor) -> None:
    """End the workers at once: after the last chunk they idle, after Ctrl-C nobody waits for them."""
    workers = list((pool._processes or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for worker in workers:
        worker.terminate()
    for worker in workers:
        worker.join()


def plan(trials: int, friction: Sequence[float], friction_trials: int) -> list[Chunk]:
    """All chunks: without friction, then with."""
    wanted = [(0.0, trials), *((mu, friction_trials) for mu in friction if mu > 0)]
    return [(mu, at, min(at + CHUNK, count)) for mu, count in wanted for at in range(0, count, CHUNK)]


class Table:
    """Chunks that ended, in a file where one is given; of other kernels' chunks nothing is kept."""

    def __init__(self, folder: Path | None) -> None:
        self.path = None if folder is None else folder / "statics_convergence.json"
        self.chunks: dict[Chunk, dict[str, Any]] = {}
        if self.path is not None and self.path.exists():
            kept = json.loads(self.path.read_text())
            if kept.get("kernels") == STAMP:
                self.chunks = {(c["friction"], c["first"], c["last"]): c for c in kept["chunks"]}

    def add(self, chunk: dict[str, Any]) -> None:
        """Keep a chunk."""
        self.chunks[chunk["friction"], chunk["first"], chunk["last"]] = chunk

    def write(self, summary: dict[str, Any]) -> None:
        """Put everything on disc, whole or not at all."""
        if self.path is not None:
            table = {"kernels": STAMP, "summary": summary, "chunks": [self.chunks[key] for key in sorted(self.chunks)]}
            with atomic_file(self.path) as draft:
                draft.write_text(json.dumps(table) + "\n")


def sum_up(table: Table, wanted: Sequence[Chunk]) -> dict[str, Any]:
    """The summary by friction of what of ``wanted`` ended."""
    ended: dict[float, list[dict[str, Any]]] = {}
    for chunk in wanted:
        if chunk in table.chunks:
            ended.setdefault(chunk[0], []).append(table.chunks[chunk])
    return {f"{mu:g}": summarise(chunks) for mu, chunks in ended.items()}


def holds(summary: dict[str, Any]) -> bool:
    """Whether the claims hold in every part of the summary."""
    return all(
        part["not_finite"] == 0 and part["converged"] >= BAR.get(float(mu), BAR_FRICTION)
        for mu, part in summary.items()
    )


def format_summary(summary: dict[str, Any]) -> str:
    """The summary as lines of text."""
    lines = []
    for mu, part in summary.items():
        counts = ", ".join(f"{count} {name}" for name, count in part["status"].items() if count)
        times = ", ".join(f"{name} {value:.2f}" for name, value in part["ms"].items())
        lines += [
            f"friction {mu}: {100 * part['converged']:.3f} % of {part['trials']} converged ({counts})",
            f"  worst residual {part['worst_residual_nm']:.1e} N m, cable {part['worst_excess_m']:.1e} m, "
            f"{part['not_finite']} not finite; ms: {times}",
        ]
        if part["failed"]:
            lines.append(f"  not converged: trials {part['failed']}")
    return "\n".join(lines)


def parse(argv: Sequence[str] | None) -> argparse.Namespace:
    """What was asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--trials", type=int, default=100_000, help="without friction")
    parser.add_argument("--friction", type=float, nargs="*", default=[0.1, 0.2, 0.4], metavar="MU")
    parser.add_argument("--friction-trials", type=int, default=1000, help="for each friction")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="write statics_convergence.json there, and go on from it"
    )
    return parser.parse_args(argv)


def main(argv: Sequence[str] | None = None) -> int:
    """Solve, print, and write the table where asked to."""
    asked = parse(argv)
    wanted = plan(asked.trials, asked.friction, asked.friction_trials)
    table, code = Table(asked.out), 0
    missing = [chunk for chunk in wanted if chunk not in table.chunks]
    written = began = time.monotonic()
    try:
        for done, chunk in enumerate(run_chunks(missing, asked.workers), start=1):
            table.add(chunk)
            left = (time.monotonic() - began) * (len(missing) / done - 1)
            failed = f", {len(chunk['failed'])} failed" if chunk["failed"] else ""
            print(f"{done}/{len(missing)} chunks{failed}, {left:.0f} s left", file=sys.stderr)
            if time.monotonic() - written > 10:
                table.write(sum_up(table, wanted))
                written = time.monotonic()
    except KeyboardInterrupt:
        code = 130
        print("interrupted", file=sys.stderr)
    summary = sum_up(table, wanted)
    table.write(summary)
    print(format_summary(summary))
    return code or (0 if holds(summary) else 1)


if __name__ == "__main__":
    sys.exit(main())
