"""Read a C3D file by ezc3d: a task of `files.limited_process`.

It imports nothing of the package, so that its process starts as fast as what it needs.
"""

from __future__ import annotations

import io
import json
import math
from itertools import takewhile
from typing import Any


def run_read(sent: bytes) -> bytes:
    """A line of JSON with rate, unit, labels and first frame, or an error; then the arrays of points and residuals.

    Args:
        sent: the path of the file.
    """
    import numpy as np

    output = io.BytesIO()
    try:
        import ezc3d  # type: ignore[import-untyped]

        content = ezc3d.c3d(sent.decode("utf-8", "surrogateescape"))
        point, data = content["parameters"]["POINT"], content["data"]
        head = {
            "rate": float(_first(point, "RATE", math.nan)), "unit": str(_first(point, "UNITS", "")).strip(),
            "labels": _labels(point), "first_frame": int(content["header"]["points"]["first_frame"]),
        }  # fmt: skip
        arrays = [np.asarray(data["points"], float), np.asarray(data["meta_points"]["residuals"], float)]
    except Exception as error:  # ezc3d raises whatever C++ throws.
        return json.dumps({"error": str(error) or type(error).__name__}).encode()
    output.write(json.dumps(head).encode() + b"\n")
    for array in arrays:
        np.save(output, array)
    return output.getvalue()


def _first(group: Any, key: str, default: object) -> Any:
    import numpy as np

    values = np.ravel(group[key]["value"]) if key in group else np.empty(0)
    return values[0] if len(values) else default


def _labels(group: Any) -> list[str]:
    """All labels, those of LABELS2 and so on included."""
    keys = takewhile(group.__contains__, ("LABELS", *(f"LABELS{i}" for i in range(2, 100))))
    return [str(name).strip() for key in keys for name in group[key]["value"]]
