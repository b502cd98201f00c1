"""``spiraltrunk export``: printable parts and simulation models of a design."""

from __future__ import annotations

import argparse
import os
import sys
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_number, read_seed, read_text
from spiraltrunk.cli.output import DONE, FAILED, Answer, UsageError, add_file_count, format_json, open_out, quote
from spiraltrunk.cli.progress import show_progress

if TYPE_CHECKING:
    from spiraltrunk.workflows.export.export import Request


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "export", _run, "write printable parts and simulation models, checked (extra cad)")
    parser.add_argument(
        "design", type=read_text, nargs="?", default="paper", metavar="DESIGN",
        help="preset or TOML file (default paper); before --parts and --formats",
    )  # fmt: skip
    parser.add_argument(
        "--parts", type=read_text, nargs="+", metavar="NAME",
        help="all (default), or some of trunk, gripper, shells, moulds, housing, drums, horn, adapter, wedge, markers",
    )  # fmt: skip
    parser.add_argument(
        "--formats", type=read_text, nargs="+", default=["step", "stl", "3mf", "mjcf", "urdf"], metavar="FORMAT",
        help="of parts: step, stl, 3mf; of the whole robot: mjcf, urdf (default all)",
    )  # fmt: skip
    parser.add_argument(
        "--tolerance-mm", type=read_number, default=0.05, metavar="MM", help="tolerance of the meshes (default 0.05)"
    )
    parser.add_argument(
        "--nozzle-mm",
        type=read_number,
        default=0.4,
        metavar="MM",
        help="the printer's nozzle diameter (default 0.4)",
    )
    parser.add_argument(
        "--bed-mm", type=read_number, nargs=3, default=[256.0] * 3, metavar=("X", "Y", "Z"),
        help="build volume of the printer (default 256 256 256); the trunk is split to fit",
    )  # fmt: skip
    parser.add_argument("--seed", type=read_seed, default=0, help="seed of the shells' wrinkles (default 0)")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write there; without it parts are only checked")


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design
    from spiraltrunk.workflows.export.export import WRITER, check_robot, export_robot

    request = _build_request(arguments)
    design = load_design(arguments.design)
    with open_out(arguments.out, WRITER) as output, show_progress(sys.stderr) as progress:
        if output is None:
            result = check_robot(design, request, progress=progress)
        else:
            result = export_robot(design, output, request, progress=progress)
    agreement = result["agreement"] or {}
    code = DONE if all(row.get("holds", True) for row in agreement.values()) else FAILED
    if arguments.json:
        return code, format_json(result)
    removed = f"; {len(result['removed'])} of an earlier export are removed" if result.get("removed") else ""
    return code, add_file_count(_format_table(result), result, arguments, "\n") + removed


def _build_request(arguments: argparse.Namespace) -> Request:
    """The parts and formats to make.

    Raises:
        UnknownName: for a part or a format that does not exist.
        DesignError: for a number out of range, with its option.
    """
    from spiraltrunk.cad.components.options import MakeOptions
    from spiraltrunk.cad.output.make_part import FORMATS as PART_FORMATS
    from spiraltrunk.design import presets
    from spiraltrunk.errors import DesignError
    from spiraltrunk.workflows.export.export import MOST_WORKERS, Request

    parts = arguments.parts or ["all"]
    for name in (*parts, *arguments.formats):
        if name in presets.NAMES or name.endswith(".toml"):
            raise UsageError(f"{quote(name)} stands behind --parts or --formats; allowed: the design before these")
    try:
        options = MakeOptions(
            nozzle=float(arguments.nozzle_mm), tolerance=float(arguments.tolerance_mm), seed=arguments.seed,
            bed=tuple(float(size) for size in arguments.bed_mm),  # type: ignore[arg-type]
        )  # fmt: skip
    except DesignError as error:
        raise DesignError(f"--{error.name.replace('_', '-')}", got=error.got, allowed=error.allowed) from None
    workers = min(MOST_WORKERS, len(os.sched_getaffinity(0)))
    request = Request(parts=tuple(parts), formats=tuple(arguments.formats), options=options, workers=workers)
    if "all" not in parts and not request.part_formats:
        given = f"--parts {' '.join(parts)} given with --formats {' '.join(arguments.formats)}"
        allowed = f"with --parts one of {', '.join(PART_FORMATS)}, or these formats, of the whole robot, alone"
        raise UsageError(f"{given}; allowed: {allowed}")
    return request


def _format_table(result: dict[str, Any]) -> str:
    from spiraltrunk.report import format_table

    rows = [
        (name, f"{1e6 * check['volume_m3']:.2f}", f"{1e3 * check['min_wall_m']:.2f}",
         f"{1e3 * result['print_mass_kg'][name]:.1f}", "holds" if check["holds"] else "; ".join(check["faults"]))
        for name, check in result["checks"].items()
    ]  # fmt: skip
    lines = [format_table(rows, header=("part", "cm^3", "wall mm", "g", "")) if rows else "no parts"]
    for name, row in (result["agreement"] or {}).items():
        if "holds" in row:
            errors = " and ".join(f"{key} {row[key]:.1e}" for key in ("solids", "simulation") if row[key] is not None)
            unit = " m" if row["unit"] == "m" else ""
            verdict = "holds" if row["holds"] else "missed"
            compared = "" if row["judged"] == "both" else f"; compared: {row['judged']}"
            lines.append(
                f"{name}: {errors}{unit} off the design, {verdict} (allowed {row['allowed']:g}{unit}{compared})"
            )
    return "\n".join(lines)
