"""MuJoCo's own words: it prints warnings, and appends them to a file in the working folder, which nobody asked for."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def quiet_mujoco() -> Iterator[None]:
    """Log MuJoCo's warnings for who wants to read them, at level debug, in place of printing and writing them."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_log)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _log(words: str) -> None:
    logging.getLogger("spiraltrunk.mujoco").debug("%s", words)
