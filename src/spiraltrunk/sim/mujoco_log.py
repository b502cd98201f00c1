"""MuJoCo's warnings, which it prints and appends to a file in the working folder by default."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def quiet_mujoco() -> Iterator[None]:
    """Log MuJoCo's warnings at level debug within the block."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_log)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _log(message: str) -> None:
    logging.getLogger("spiraltrunk.mujoco").debug("%s", message)
