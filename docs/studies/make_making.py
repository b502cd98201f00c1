"""Make the pictures and figures of validation/making.md: all parts of the paper's robot in all formats."""

from __future__ import annotations

import json
import os
import resource
import shutil
import tempfile
import time
from pathlib import Path

from spiraltrunk.design import presets
from spiraltrunk.workflows.export.export import Request, export_robot

DOCS = Path(__file__).parents[1]


def main() -> None:
    """Export the robot, keep two pictures and the figures."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        result = export_robot(presets.get("paper"), folder, Request(workers=2))
        wall = time.perf_counter() - began
        for name in ("exploded.png", "parts.png"):
            shutil.copyfile(Path(folder) / "pictures" / name, DOCS / "images" / f"making_{name}")
    spent = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    figures = {
        "parts": len(result["checks"]),
        "files": len(result["files"]),
        "wall_s": round(wall, 1),
        "processor_s": round(sum(usage.ru_utime + usage.ru_stime for usage in spent), 1),
        "load_average": round(os.getloadavg()[0], 1),
        "thinnest_printed_wall_mm": round(
            1e3 * min(c["min_wall_m"] for name, c in result["checks"].items() if not name.startswith("shell")), 2
        ),
        "print_mass_g": round(1e3 * sum(m for name, m in result["print_mass_kg"].items() if name.startswith("trunk"))),
        "agreement": {name: row for name, row in result["agreement"].items() if name != "density"},
        "density_kg_per_m3": [round(value) for value in result["agreement"]["density"]["kg_per_m3"]],
    }
    (DOCS / "studies" / "making.json").write_text(json.dumps(figures, indent=2) + "\n")
    print(json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
