"""Measured shapes as JSON, in SI; null for numbers that are not finite."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from spiraltrunk.errors import ModelError, TakeError
from spiraltrunk.files.atomic import write_file
from spiraltrunk.files.results import to_json
from spiraltrunk.files.text_lines import open_take
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes

_SCHEMA = 1
_MOST_BYTES = 100_000_000
_ARRAYS = {
    "theta_0": "theta_0_rad", "pull": "pull_m", "follows": "follows", "marker_offset": "seat_m", "points": "points_m",
    "rotation": "rotation",
}  # fmt: skip


def write_shapes(shapes: MeasuredShapes, path: str | Path) -> Path:
    """Write the shapes atomically; an OSError where the file cannot be written."""
    target = Path(path)
    document: dict[str, Any] = {"schema": _SCHEMA, "kind": list(shapes.kind), "take": list(shapes.take)}
    document |= {key: getattr(shapes, field) for field, key in _ARRAYS.items()}
    write_file(target, (json.dumps(to_json(document), allow_nan=False) + "\n").encode())
    return target


def load_shapes(path: str | Path) -> MeasuredShapes:
    """Read shapes that `write_shapes` wrote; a TakeError for any other file."""
    with open_take(path) as file:
        data = file.read(_MOST_BYTES + 1)
    try:
        if len(data) > _MOST_BYTES:
            raise ValueError(f"it has more than {_MOST_BYTES} bytes")
        document = json.loads(data)
        if not isinstance(document, dict) or document.get("schema") != _SCHEMA:
            raise ValueError(f"it has no schema {_SCHEMA}")
        texts = {key: tuple(str(value) for value in document[key]) for key in ("kind", "take")}
        arrays = {field: np.array(document[key], float) for field, key in _ARRAYS.items()}
        arrays["follows"] = np.rint(arrays["follows"]).astype(int)
        return MeasuredShapes(kind=texts["kind"], take=texts["take"], **arrays)
    except (ValueError, TypeError, KeyError, RecursionError, OverflowError, ModelError) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else " ".join(str(error).split())[:200]
        raise TakeError(f"{what}; allowed: shapes as spiraltrunk validate writes them", file=str(path)) from None
