"""Making of one part: its solid, mesh, checks and files; the job of one worker process."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np

import spiraltrunk
from spiraltrunk.cad.checks.agreement import place_faces
from spiraltrunk.cad.checks.printability import Finding, check_part
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.components.print_settings import find_settings
from spiraltrunk.cad.geometry.csg import compute_volume
from spiraltrunk.cad.geometry.occ import (
    build_mesh,
    build_solid,
    measure_cones,
    measure_cylinders,
    write_3mf,
    write_step,
)
from spiraltrunk.cad.geometry.part import Part

if TYPE_CHECKING:
    from trimesh import Trimesh

FORMATS = ("step", "stl", "3mf")
"""Formats of parts."""


@final
@dataclass(frozen=True, kw_only=True)
class MadePart:
    """A part with its mesh and the result of its checks."""

    part: Part
    """Its definition."""
    mesh: Trimesh
    """Its surface, in its own frame [mm]."""
    finding: Finding
    """Result of its checks."""
    faces: tuple[float, np.ndarray, np.ndarray] | None
    """Cones and cable holes of a piece of the trunk, for `agreement.measure_trunk`."""

    @property
    def checks(self) -> dict[str, Any]:
        """Result of the checks by the keys of ``spiraltrunk export --json``."""
        finding = self.finding
        return {
            "watertight": finding.watertight,
            "volume_m3": 1e-9 * finding.volume,
            "expected_volume_m3": 1e-9 * finding.expected,
            "min_wall_m": 1e-3 * finding.min_wall,
            "min_wall_at_m": [1e-3 * value for value in finding.at],
            "size_m": [1e-3 * value for value in finding.size],
            "triangles": len(self.mesh.faces),
            "faults": list(finding.faults),
            "holds": finding.holds,
        }


def make_part(part: Part, options: MakeOptions, formats: tuple[str, ...], folder: Path | None, design: str) -> MadePart:
    """Make a part and write it, with a JSON of its data, to a folder, if one is given.

    Args:
        part: its definition.
        options: how it is made.
        formats: selected from `FORMATS`.
        folder: an existing folder, or None for checks only.
        design: name of the design, for the JSON.

    Raises:
        OSError: where a file cannot be written.
    """
    solid = build_solid(part.form)
    mesh = build_mesh(solid, options.tolerance, options.remedies.tolerance)
    faces = None
    if part.group == "trunk":
        faces = place_faces(part, measure_cones(solid), measure_cylinders(solid, options.hole / 2))
    finding = check_part(part, solid, mesh, compute_volume(part.form), options)
    made = MadePart(part=part, mesh=mesh, finding=finding, faces=faces)
    if folder is not None and made.finding.holds:
        if "step" in formats:
            write_step(solid, folder / f"{part.name}.step", part.name)
        if "stl" in formats:
            mesh.export(folder / f"{part.name}.stl")
        if "3mf" in formats:
            write_3mf(mesh, folder / f"{part.name}.3mf", part.name)
        about: dict[str, Any] = {
            "part": part.name, "what": part.what, "count": part.count, "material": part.material.name, "unit": "mm",
            "design": design, "seed": options.seed, "tolerance_mm": options.tolerance, "nozzle_mm": options.nozzle,
            "spiraltrunk": spiraltrunk.__version__, "checks": made.checks,
        }  # fmt: skip
        if not part.material.is_cast:
            settings = find_settings(part.name)
            about["print"] = {"layer_mm": settings.layer(options), **asdict(settings)}
        (folder / f"{part.name}.json").write_text(json.dumps(about, indent=2, allow_nan=False) + "\n")
    return made
