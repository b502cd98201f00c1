"""Messages of MuJoCo: by default it prints warnings, and appends them to a file in the working folder."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco

_log = logging.getLogger("spiraltrunk.mujoco").debug


@contextmanager
def quiet_mujoco() -> Iterator[None]:
    """Log MuJoCo's warnings at level debug instead of printing and writing them."""
    with quiet_steps(), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # MjSpec.compile warns twice.
        yield


@contextmanager
def quiet_steps() -> Iterator[None]:
    """`quiet_mujoco` for what compiles nothing, in a hundredth of a millisecond less."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_log)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def compile_spec(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """Compile a spec; what it warns of, such as settings of an attached file that do not apply, is logged."""
    with quiet_mujoco():
        return spec.compile()


def first_line(error: Exception) -> str:
    """MuJoCo's message on one line of at most 200 characters."""
    return " ".join(str(error).split())[:200] or "no reason given"
