"""The maker's output: parts, models, bill, guide and pictures of one design in one folder, all of them or none."""

from __future__ import annotations

import hashlib
import json
import re
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any, final

import spiraltrunk
from spiraltrunk.cad.checks.agreement import measure_trunk
from spiraltrunk.cad.checks.assembly import check_hardware
from spiraltrunk.cad.checks.self_collision import check_curl
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.occ import check_packages
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.output import make_part
from spiraltrunk.cad.output.assembly_guide import format_guide
from spiraltrunk.cad.output.bill_of_materials import build_bill, estimate_print, format_csv, format_markdown
from spiraltrunk.cad.output.catalogue import build_parts, check_groups
from spiraltrunk.cad.output.make_part import Made
from spiraltrunk.design.toml import load_design, write_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import PartError, UnknownName
from spiraltrunk.files.atomic import atomic_folder, check_foreign_files
from spiraltrunk.report.solids.exploded import PlacedPart, write_pictures
from spiraltrunk.workflows.export.agreement import compute_agreement

MODEL_FORMATS = ("mjcf", "urdf")
"""Formats of the whole robot for simulators."""

FORMATS = (*make_part.FORMATS, *MODEL_FORMATS)
"""Everything that `--formats` may ask for."""

Tell = Callable[[str, int, int], None]
"""Called with what is being made, how much of it is done and how much there is."""

_OURS = re.compile(r"(?:(?:parts|models|models/assets|pictures)/)?[A-Za-z0-9_]+(?:\.[A-Za-z0-9]+)+")
"""Paths below the folder that an export may have written."""

_FIRST = ("bom.csv", "bom.md", "guide.md", "result.json", "trunk.toml")
"""Files that are looked for before the work begins; for the others it is done at its end."""

_HEAVIEST = {"trunk": 0, "gripper": 1, "housing": 2}
"""What takes longest is begun first."""


@final
@dataclass(frozen=True, kw_only=True)
class Request:
    """What is to be made of a design."""

    parts: tuple[str, ...] = ("all",)
    """Groups of parts (`cad.catalogue.GROUPS`), or "all"."""
    formats: tuple[str, ...] = FORMATS
    """Formats of parts and models."""
    options: MakeOptions = field(default_factory=MakeOptions)
    """How the parts are made."""
    workers: int = 1
    """Processes that make parts; more than one need a main module that can be imported."""

    def __post_init__(self) -> None:
        check_groups(self.parts)
        for name in self.formats:
            if name not in FORMATS:
                raise UnknownName("format", name, FORMATS)

    @property
    def part_formats(self) -> tuple[str, ...]:
        """The formats of parts that are asked for."""
        return tuple(name for name in self.formats if name in make_part.FORMATS)

    @property
    def model_formats(self) -> tuple[str, ...]:
        """The formats of models that are asked for."""
        return tuple(name for name in self.formats if name in MODEL_FORMATS)


def export_robot(
    design: TrunkDesign, folder: str | Path, request: Request | None = None, *, tell: Tell | None = None
) -> dict[str, Any]:
    """Make and check everything, then put it into the folder; where anything fails, the folder stays as it was.

    Args:
        design: the robot.
        folder: where to, made where it is missing. What an earlier export left there goes; others' files stay.
        request: what to make; everything by default.
        tell: called as the work goes on.

    Returns:
        What was made, ready for JSON: ``files, checks, mass_kg`` and more; ``removed`` are an earlier export's files.

    Raises:
        PartError: for a part that fails its checks: which, where and by how much.
        DesignError: for a design that a part cannot be derived from.
        MissingPackage: where build123d is needed and not installed.
        OSError: where the folder cannot be written, or holds a file of a name that is needed.
    """
    request, tell = request or Request(), tell or _tell_nobody
    definitions: tuple[Part, ...] = ()
    if request.part_formats:
        definitions = _define(design, request)
    earlier = _read_earlier(Path(folder), design)
    check_foreign_files(folder, _FIRST, earlier)
    with atomic_folder(folder, earlier) as draft:
        result = _fill(design, draft, request, definitions, tell)
    return result | {"removed": sorted(set(earlier) - set(result["files"]))}


def check_robot(design: TrunkDesign, request: Request | None = None, *, tell: Tell | None = None) -> dict[str, Any]:
    """Make and check everything as `export_robot` does, and write nothing; ``files`` is empty.

    Raises:
        As `export_robot`, but for OSError.
    """
    request = request or Request()
    definitions = _define(design, request)
    made = _make(design, None, request, definitions, tell or _tell_nobody)
    return _summarise(design, request, made, ())


def _define(design: TrunkDesign, request: Request) -> tuple[Part, ...]:
    """The parts that are asked for, after all that can be checked of their definitions."""
    check_packages()
    check_curl(design)
    parts = build_parts(design, request.parts, request.options)
    check_hardware(design, request.options, parts)
    return parts


def _fill(
    design: TrunkDesign, draft: Path, request: Request, definitions: tuple[Part, ...], tell: Tell
) -> dict[str, Any]:
    """Write everything into the draft."""
    made: list[Made] = []
    if definitions:
        (draft / "parts").mkdir()
        made = _make(design, draft / "parts", request, definitions, tell)
        tell("pictures", 0, 1)
        _draw(design, made, draft / "pictures")
        rows = build_bill(design, made, request.options)
        (draft / "bom.md").write_text(format_markdown(design, rows))
        (draft / "bom.csv").write_text(format_csv(rows))
        (draft / "guide.md").write_text(format_guide(design, made, request.options))
    if request.model_formats:
        from spiraltrunk.sim.export_models import write_models

        tell("models", 0, 1)
        write_models(design, draft / "models", request.model_formats)
    write_design(design, draft / "trunk.toml")
    files = tuple(
        sorted({*(str(path.relative_to(draft)) for path in draft.rglob("*") if path.is_file()), "result.json"})
    )
    result = _summarise(design, request, made, files)
    result["design_sha256"] = _hash(draft / "trunk.toml")
    (draft / "result.json").write_text(json.dumps(result, indent=2, allow_nan=False) + "\n")
    return result


def _make(
    design: TrunkDesign, folder: Path | None, request: Request, definitions: tuple[Part, ...], tell: Tell
) -> list[Made]:
    """All parts, in the order of their definitions.

    Raises:
        PartError: with the first fault, and how many there are.
    """
    jobs = sorted(definitions, key=lambda part: _HEAVIEST.get(part.group, 9))
    made: dict[str, Made] = {}
    arguments = (request.options, request.part_formats, folder, design.name)
    if _count_workers(jobs, request.workers) == 1:
        for part in jobs:
            tell(part.name, len(made), len(jobs))
            made[part.name] = make_part.make_part(part, *arguments)
    else:
        with _open_pool(_count_workers(jobs, request.workers)) as pool:
            waiting: dict[Future[Made], str] = {
                pool.submit(make_part.make_part, part, *arguments): part.name for part in jobs
            }
            tell("parts", 0, len(jobs))
            for done in as_completed(waiting):
                made[waiting[done]] = done.result()
                tell(waiting[done], len(made), len(jobs))
    found = [made[part.name] for part in definitions]
    faults = [f"part {one.part.name}: {fault}" for one in found for fault in one.finding.faults]
    if faults:
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        raise PartError(f"{faults[0]}{more}")
    return found


def _count_workers(jobs: Sequence[Part], most: int) -> int:
    """Processes that are worth it: each first loads the kernel, which takes as long as a dozen small parts."""
    heavy = sum(part.group in _HEAVIEST for part in jobs)
    return max(1, min(most, heavy + (len(jobs) - heavy) // 12))


@contextmanager
def _open_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that start afresh; when the work is cut short, they end at once: a part may take half a minute."""
    others = set(active_children())
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_ignore_interrupts)
    try:
        yield pool
    except BaseException:
        for process in set(active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _ignore_interrupts() -> None:
    """Ctrl-C goes to all processes of a terminal; the first one decides."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _draw(design: TrunkDesign, made: Sequence[Made], folder: Path) -> None:
    parts = [
        PlacedPart(
            name=one.part.name, group=one.part.group, count=one.part.count, mesh=one.mesh, at=one.part.at,
            turn=one.part.turn,
        )
        for one in made
    ]  # fmt: skip
    write_pictures(parts, folder, title=" ".join(design.name.split()), n_cable=design.n_cable)


def _summarise(design: TrunkDesign, request: Request, made: Sequence[Made], files: tuple[str, ...]) -> dict[str, Any]:
    options = request.options
    estimates = {one.part.name: estimate_print(one, options) for one in made}
    result: dict[str, Any] = {
        "design": design.name,
        "files": list(files),
        "checks": {one.part.name: one.checks for one in made},
        "mass_kg": design.total_mass,
        "print_mass_kg": {name: 1e-3 * mass for name, (mass, _) in estimates.items()},
        "print_time_h": {name: hours for name, (_, hours) in estimates.items()},
        "curl_overlap_m": check_curl(design).depth,
        "agreement": None,
        "options": {**asdict(options), "bed": list(options.bed)},
        "formats": list(request.formats),
        "spiraltrunk": spiraltrunk.__version__,
    }
    pieces = [one.place_faces() for one in made if one.part.group == "trunk"]
    if pieces:
        result["agreement"] = compute_agreement(design, measure_trunk(design, pieces))
    return result


def _hash(path: Path) -> str:
    """What a file says, in a few letters."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _read_earlier(target: Path, wanted: TrunkDesign) -> list[str]:
    """Files that an earlier export says it wrote; none that could lie elsewhere, no other design than it wrote."""
    try:
        found = json.loads((target / "result.json").read_text())
        names = found["files"] if "checks" in found else []
        ours = [name for name in names if isinstance(name, str) and _OURS.fullmatch(name)]
        path = target / "trunk.toml"
        if path.exists() and _hash(path) != found.get("design_sha256") and load_design(path) != wanted:
            ours = [name for name in ours if name != path.name]
        return ours
    except (OSError, ValueError, TypeError, KeyError):  # A DesignError is a ValueError.
        return []


def _tell_nobody(what: str, done: int, total: int) -> None:
    """Say nothing."""
