"""Export of a robot: parts, models, bill of materials, guide and pictures in one folder, written atomically."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, field
from functools import partial
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
from spiraltrunk.cad.output.bill_of_materials import build_bill, estimate_print, format_csv, format_markdown
from spiraltrunk.cad.output.catalogue import build_parts, check_groups
from spiraltrunk.cad.output.guide.assembly_guide import format_guide
from spiraltrunk.cad.output.make_part import MadePart
from spiraltrunk.cad.output.top_view import format_top_view
from spiraltrunk.design.toml import format_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import PartError, UnknownName
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.manifest import compute_digest
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.files.results import Progress, format_json, ignore_progress
from spiraltrunk.processes.pool import run_jobs
from spiraltrunk.report.solids.pictures import PlacedPart, write_pictures
from spiraltrunk.workflows.export.agreement import compute_agreement

MODEL_FORMATS = ("mjcf", "urdf")
"""Formats of the whole robot for simulators."""

FORMATS = (*make_part.FORMATS, *MODEL_FORMATS)
"""All formats."""

MOST_WORKERS = 4
"""Most processes that are useful: each holds the CAD kernel in memory, and few parts take long (ours)."""

WRITER = "export"
"""Name of the command in output folders."""

_LISTS = ("bom.csv", "bom.md", "guide.md")
"""Files about the parts."""

_PICTURES = ("pictures/exploded.png", "pictures/exploded.svg", "pictures/parts.png")
"""Pictures of the parts."""

_TOP_VIEW = "pictures/top_view.svg"
"""Picture of the open housing, where it is made."""

_HEAVIEST = {"trunk": 0, "gripper": 1, "housing": 2}
"""Groups whose parts take longest, in the order in which they are started."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Request:
    """Selection of parts and formats of a design, and how to make them."""

    parts: tuple[str, ...] = ("all",)
    """Groups of parts (`cad.catalogue.GROUPS`), or "all"."""
    formats: tuple[str, ...] = FORMATS
    """Formats of parts and models."""
    options: MakeOptions = field(default_factory=MakeOptions)
    """How the parts are made."""
    workers: int = 1
    """Processes that make parts."""

    def __post_init__(self) -> None:
        check_groups(self.parts)
        for name in self.formats:
            if name not in FORMATS:
                raise UnknownName("format", name, FORMATS)

    @property
    def part_formats(self) -> tuple[str, ...]:
        """The selected formats of parts."""
        return tuple(name for name in self.formats if name in make_part.FORMATS)


def export_robot(
    design: TrunkDesign,
    folder: str | Path | OutputFolder,
    request: Request | None = None,
    *,
    progress: Progress = ignore_progress,
) -> dict[str, Any]:
    """Make and check the parts and models, then write them to the folder; where anything fails, it stays unchanged.

    Args:
        design: the robot.
        folder: where to, made where it is missing. Unchanged files of an earlier export are removed, all others stay.
        request: what to make; everything by default.
        progress: called as the work goes on.

    Returns:
        The result, ready for JSON: ``files, checks, mass_kg`` and more; ``removed`` lists an earlier export's files.

    Raises:
        PartError: for a part that fails its checks; says which, where and by how much.
        DesignError: for a design from which a part cannot be derived.
        MissingPackage: where build123d is needed and not installed.
        OutputError: where a file cannot be written or must not be replaced.
    """
    request = request or Request()
    definitions = _define(design, request) if request.part_formats else ()
    with open_output(folder, WRITER, _list_files(request, definitions)) as output:
        with output.draft() as draft:
            result = _fill(design, draft, request, definitions, progress)
        return result | {"removed": output.removed}


def _list_files(request: Request, definitions: Sequence[Part]) -> list[str]:
    """Files that are known before the work begins: all but the models."""
    names = ["result.json", "trunk.toml"]
    if definitions:
        endings = (*request.part_formats, "json")
        names += [f"parts/{part.name}.{ending}" for part in definitions for ending in endings]
        names += [*_LISTS, *_PICTURES, *([_TOP_VIEW] if _has_housing(definitions) else [])]
    return names


def _has_housing(definitions: Sequence[Part]) -> bool:
    return any(part.group == "housing" for part in definitions)


def check_robot(
    design: TrunkDesign, request: Request | None = None, *, progress: Progress = ignore_progress
) -> dict[str, Any]:
    """Make and check as `export_robot` does, without writing; ``files`` is empty.

    Raises:
        As `export_robot`, but for OSError.
    """
    request = request or Request()
    definitions = _define(design, request) if request.part_formats else ()
    made = _make(design, None, request, definitions, progress) if definitions else []
    return _summarise(design, request, made, [])


def _define(design: TrunkDesign, request: Request) -> tuple[Part, ...]:
    """Definitions of the selected parts, checked before anything is made."""
    check_packages()
    check_curl(design)
    parts = build_parts(design, request.parts, request.options)
    check_hardware(design, request.options, parts)
    return parts


def _fill(
    design: TrunkDesign, draft: Path, request: Request, definitions: tuple[Part, ...], progress: Progress
) -> dict[str, Any]:
    """Write everything to the draft folder."""
    made: list[MadePart] = []
    if definitions:
        (draft / "parts").mkdir()
        made = _make(design, draft / "parts", request, definitions, progress)
        progress("pictures", 0, 1)
        parts = [
            PlacedPart(
                name=one.part.name, group=one.part.group, count=one.part.count, mesh=one.mesh, at=one.part.at,
                turn=one.part.turn,
            )
            for one in made
        ]  # fmt: skip
        write_pictures(parts, draft / "pictures", title=" ".join(design.name.split()), n_cable=design.n_cable)
        if _has_housing(definitions):
            write_text(draft / _TOP_VIEW, format_top_view(design, request.options))
        bill = build_bill(design, made, request.options)
        guide = format_guide(design, [one.part for one in made], bill, request.options)
        write_text(draft / "bom.md", format_markdown(design, bill))
        write_text(draft / "bom.csv", format_csv(bill))
        write_text(draft / "guide.md", guide)
    model_formats = tuple(name for name in request.formats if name in MODEL_FORMATS)
    if model_formats:
        from spiraltrunk.sim.export_models import write_models

        progress("models", 0, 1)
        write_models(design, draft / "models", model_formats)
    write_text(draft / "trunk.toml", format_design(design))
    written = {str(path.relative_to(draft)) for path in draft.rglob("*") if path.is_file()}
    result = _summarise(design, request, made, sorted({*written, "result.json"}))
    result["design_sha256"] = compute_digest(draft / "trunk.toml")
    write_text(draft / "result.json", format_json(result) + "\n")
    return result


def _make(
    design: TrunkDesign, folder: Path | None, request: Request, definitions: tuple[Part, ...], progress: Progress
) -> list[MadePart]:
    """Make all parts; the result is in the order of their definitions.

    Raises:
        PartError: with the first fault and the number of others.
    """
    jobs = sorted(definitions, key=lambda part: _HEAVIEST.get(part.group, 9))
    work = partial(
        make_part.make_part, options=request.options, formats=request.part_formats, folder=folder, design=design.name
    )
    made: dict[str, MadePart] = {}
    progress("parts", 0, len(jobs))
    with closing(_share(work, jobs, _count_workers(jobs, request.workers))) as finished:
        for one in finished:
            made[one.part.name] = one
            progress(one.part.name, len(made), len(jobs))
    found = [made[part.name] for part in definitions]
    faults = [f"part {one.part.name}: {fault}" for one in found for fault in one.finding.faults]
    if faults:
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        raise PartError(f"{faults[0]}{more}")
    return found


def _count_workers(jobs: Sequence[Part], most: int) -> int:
    """Number of useful processes: loading the kernel takes each as long as a dozen small parts."""
    heavy = sum(part.group in _HEAVIEST for part in jobs)
    return max(1, min(most, heavy + (len(jobs) - heavy) // 12))


def _share(work: Callable[[Part], MadePart], jobs: Sequence[Part], workers: int) -> Generator[MadePart, None, None]:
    """Parts as they are made; closing it stops processes at once, as one part may take half a minute."""
    if workers == 1:
        yield from map(work, jobs)
        return
    with closing(run_jobs(work, jobs, workers)) as outcomes:
        for outcome in outcomes:
            yield outcome.unwrap()


def _summarise(design: TrunkDesign, request: Request, made: Sequence[MadePart], files: list[str]) -> dict[str, Any]:
    options = request.options
    estimates = {one.part.name: estimate_print(one, options) for one in made}
    result: dict[str, Any] = {
        "design": design.name,
        "files": files,
        "checks": {one.part.name: one.checks for one in made},
        "mass_kg": design.total_mass,
        "print_mass_kg": {name: 1e-3 * mass for name, (mass, _) in estimates.items()},
        "print_time_h": {name: hours for name, (_, hours) in estimates.items()},
        "curl_overlap_m": check_curl(design).depth,
        "agreement": None,
        "options": {name: value for name, value in asdict(options).items() if name != "remedies"}
        | {"bed": list(options.bed)},
        "formats": list(request.formats),
        "spiraltrunk": spiraltrunk.__version__,
    }
    pieces = [one.faces for one in made if one.faces is not None]
    if pieces:
        result["agreement"] = compute_agreement(design, measure_trunk(design, pieces))
    return result
