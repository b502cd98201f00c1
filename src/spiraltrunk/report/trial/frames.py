"""What a frame is."""

from __future__ import annotations

import numpy as np

from spiraltrunk.errors import ShapeError


def check_frame(frame: np.ndarray, shape: tuple[int, ...], name: str) -> None:
    """Nothing, where a frame is a picture of the given shape.

    Raises:
        ShapeError: where it is not.
    """
    if not isinstance(frame, np.ndarray) or frame.dtype != np.uint8 or frame.ndim != 3 or frame.shape[2] != 3:
        kind = f"{frame.shape} of {frame.dtype}" if isinstance(frame, np.ndarray) else type(frame).__name__
        raise ShapeError(f"{name} is {kind}; allowed: (height, width, 3) of uint8")
    if frame.shape != shape or 0 in shape:
        raise ShapeError(f"{name} has shape {frame.shape}; allowed: the first frame's, {shape}, not empty")
