"""Mutation test: how many changed operators the fast tests notice, of a sample drawn at random.

Claim (docs/validation/attacks.md): of 60 mutants drawn outside kernels and pictures, 90 % are noticed. A mutant is one
operator of `src` replaced: + by -, * by /, a comparison or a condition by its opposite, `and` by `or`, a minus sign or
a `not` left out. First the tests of the mutant's own folder run, then all fast tests, which must all pass without a
mutant; what fails, or does not end within ``--limit-s``, has noticed it. The sample depends on ``--seed`` and on the
source alone. A run that was stopped goes on where it was, with the same ``--out``.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = Path("src") / "spiraltrunk"
NOT_DRAWN = ("kernels", "kernel", "report", "render", "bench", "progress", "completion", "jit.py", "linking.py")
"""Parts of a path that are left out: machine code, pictures, and what measures or shows the time."""

BINARY: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"), ast.Pow: ("**", "*"),
}  # fmt: skip
COMPARED: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("<", ">="), ast.LtE: ("<=", ">"), ast.Gt: (">", "<="), ast.GtE: (">=", "<"), ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="), ast.Is: ("is", "is not"), ast.IsNot: ("is not", "is"), ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Mutant:
    """One operator replaced."""

    file: str
    """Path below the repository."""
    first: int
    """Offset of the first replaced byte."""
    last: int
    """Offset after the last replaced byte."""
    old: str
    """What stands there."""
    new: str
    """What is put there."""
    line: int
    """Line of the operator."""


_LATE = "no end within"
"""What notices a mutant by time alone: on a busy computer that may be no mutant's doing."""


def is_text(node: ast.AST) -> bool:
    """Whether a node is certainly a string, whose joining and formatting is not arithmetic."""
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def find_mutants(file: Path) -> Iterator[Mutant]:
    """Every mutant of one module, in the order of the source."""
    source = file.read_bytes()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def between(left: ast.expr, right: ast.expr, old: str, new: str) -> Iterator[Mutant]:
        first = starts[(left.end_lineno or 1) - 1] + (left.end_col_offset or 0)
        last = starts[right.lineno - 1] + right.col_offset
        found = source.find(old.encode(), first, last)
        if found >= 0:
            yield build(found, found + len(old.encode()), old, new, left.end_lineno or 1)

    def build(first: int, last: int, old: str, new: str, line: int) -> Mutant:
        path = file.relative_to(ROOT).as_posix()
        return Mutant(file=path, first=first, last=last, old=old, new=new, line=line)

    for node in ast.walk(ast.parse(source)):
        if (
            isinstance(node, ast.BinOp)
            and type(node.op) in BINARY
            and not is_text(node.left)
            and not is_text(node.right)
        ):
            yield from between(node.left, node.right, *BINARY[type(node.op)])
        elif isinstance(node, ast.Compare):
            operands = [node.left, *node.comparators]
            for left, right, operator in zip(operands, operands[1:], node.ops, strict=False):
                yield from between(left, right, *COMPARED[type(operator)])
        elif isinstance(node, ast.BoolOp):
            old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
            for left, right in zip(node.values, node.values[1:], strict=False):
                yield from between(left, right, old, new)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            first = starts[node.lineno - 1] + node.col_offset
            old = "-" if isinstance(node.op, ast.USub) else "not "
            yield build(first, first + len(old), old, "", node.lineno)


def draw(count: int, seed: int, below: Path = PACKAGE) -> list[Mutant]:
    """A sample of all mutants of a folder without replacement."""
    files = [file for file in sorted((ROOT / below).rglob("*.py")) if not is_left_out(file)]
    return random.Random(seed).sample([mutant for file in files for mutant in find_mutants(file)], count)


def is_left_out(file: Path) -> bool:
    """Whether a module is one of `NOT_DRAWN`."""
    path = file.relative_to(ROOT / PACKAGE).as_posix()
    return any(part in path for part in NOT_DRAWN)


def run_tests(copy: Path, tests: list[str], jobs: int, limit: float) -> str:
    """What pytest says of the first failure; empty if all pass.

    Args:
        copy: folder with the sources.
        tests: paths below it.
        jobs: processes.
        limit: time after which the tests have noticed [s].
    """
    spread = ["-n", str(jobs), "--dist", "worksteal"] if jobs > 1 else ["-n", "0"]
    command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "--tb=no", "-p", "no:cacheprovider", *spread]
    environment = {**os.environ, "PYTHONPATH": str(copy / "src"), "HYPOTHESIS_PROFILE": "default"}
    process = subprocess.Popen(
        [*command, *tests], cwd=copy, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        output, _ = process.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        return f"{_LATE} {limit:.0f} s"
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    if process.returncode in {0, 5}:  # 5: there is no test in this folder.
        return ""
    failed = [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0] if failed else output.strip().splitlines()[-1]


def nearest_tests(copy: Path, mutant: Mutant) -> list[str]:
    """The tests that mirror the mutant's folder, or the nearest one above it that has tests, and files above those."""
    folder = (copy / mutant.file).relative_to(copy / PACKAGE).parent
    while folder != Path() and not (copy / "tests" / folder).is_dir():
        folder = folder.parent
    if folder == Path():
        return sorted(path.relative_to(copy).as_posix() for path in (copy / "tests").glob("test_*.py"))
    above = [path for parent in folder.parents[:-1] for path in (copy / "tests" / parent).glob("test_*.py")]
    return [(Path("tests") / folder).as_posix(), *sorted(path.relative_to(copy).as_posix() for path in above)]


def examine(
    copy: Path, mutant: Mutant, jobs: int, limit: float, *, is_near_only: bool, own: list[str] | None = None
) -> str:
    """Put the mutant into the copy, run the tests, take it out again; what noticed it, or nothing.

    ``own`` are the tests that run first, by default those of the mutant's own folder.
    """
    file = copy / mutant.file
    source = file.read_bytes()
    if source[mutant.first : mutant.last] != mutant.old.encode():
        raise SystemExit(f"{mutant.file} has changed since the sample was drawn: begin anew with another --out")
    file.write_bytes(source[: mutant.first] + mutant.new.encode() + source[mutant.last :])
    try:
        near = nearest_tests(copy, mutant) if own is None else own
        noticed = run_tests(copy, near, jobs, limit) if near else ""
        return noticed if noticed or is_near_only else run_tests(copy, ["tests"], jobs, limit)
    finally:
        file.write_bytes(source)


def copy_sources(folder: Path) -> None:
    """The files that git knows, and those that it would add."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"], cwd=ROOT, check=True,
        capture_output=True, text=True,
    ).stdout  # fmt: skip
    for name in listed.split("\0"):
        if name and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    for command in (["init", "-q"], ["add", "-A"]):  # Some tests ask git what there is.
        subprocess.run(["git", *command], cwd=folder, check=True)


def build_parser(summary: str, count: int, out: str) -> argparse.ArgumentParser:
    """Options of a mutation test, with these defaults."""
    parser = argparse.ArgumentParser(description=summary)
    parser.add_argument("--count", type=int, default=count, metavar="N", help=f"mutants (default {count})")
    parser.add_argument("--seed", type=int, default=0, help="of the sample (default 0)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N", help="processes of the tests")
    parser.add_argument("--limit-s", type=float, default=900.0, metavar="S", help="of one run of tests (default 900)")
    parser.add_argument("--near-only", action="store_true", help="run only the tests of the mutant's own folder")
    parser.add_argument("--out", type=Path, default=Path(out), metavar="FILE", help="results, resumed")
    return parser


def examine_sample(
    sample: list[Mutant], options: argparse.Namespace, tests: list[str], own: list[str] | None = None
) -> int:
    """Examine the sample and print what was not noticed; ``tests`` must pass before. 0 where 90 % are noticed."""
    options.out.parent.mkdir(parents=True, exist_ok=True)
    lines = options.out.read_text().splitlines() if options.out.exists() else []
    known = {json.dumps(found["mutant"], sort_keys=True): found["noticed_by"] for found in map(json.loads, lines)}
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        copy_sources(copy)
        if not lines and (failed := run_tests(copy, tests, options.jobs, options.limit_s)):
            raise SystemExit(f"the tests must pass before anything is changed: {failed}")
        for number, mutant in enumerate(sample, start=1):
            key = json.dumps(asdict(mutant), sort_keys=True)
            if key not in known:
                known[key] = examine(
                    copy, mutant, options.jobs, options.limit_s, is_near_only=options.near_only, own=own
                )
                with options.out.open("a") as out:
                    out.write(json.dumps({"mutant": asdict(mutant), "noticed_by": known[key]}) + "\n")
            noticed = known[key] or "NOT NOTICED"
            print(
                f"{number}/{len(sample)} {mutant.file}:{mutant.line} {mutant.old!r} -> {mutant.new!r}: {noticed}",
                flush=True,
            )
    found = [known[json.dumps(asdict(mutant), sort_keys=True)] for mutant in sample]
    count, late = sum(map(bool, found)), sum(one.startswith(_LATE) for one in found)
    print(f"noticed: {count} of {len(sample)}, {count / len(sample):.0%}; {late} of them by the limit of time alone")
    return 0 if count >= 0.9 * len(sample) else 1


def main() -> int:
    """Examine a sample of the package."""
    options = build_parser(__doc__.partition("\n")[0], 60, "out/mutants.jsonl").parse_args()
    return examine_sample(draw(options.count, options.seed), options, ["tests"])


if __name__ == "__main__":
    sys.exit(main())
