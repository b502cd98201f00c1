"""Main function of the command line. Verbs import heavy packages when they run, so that help is fast."""

from __future__ import annotations

import errno
import logging
import os
import re
from collections.abc import Sequence
from functools import partial
from typing import final

from spiraltrunk import __version__
from spiraltrunk.cli.arguments import Parser
from spiraltrunk.cli.missing_package import describe_missing
from spiraltrunk.cli.output import BAD_INPUT, DONE, FAILED, UsageError, complain, put, send
from spiraltrunk.cli.signals import run_interruptibly
from spiraltrunk.cli.verbs import (
    bench,
    calibrate,
    completion,
    demos,
    design,
    drive,
    export,
    grasp,
    object,
    optimize,
    shape,
    studio,
    survey,
    validate,
)
from spiraltrunk.errors import RunError, SpiralTrunkError

VERBS = (
    design, shape, object, grasp, survey, demos, optimize, validate, calibrate, export, drive, studio, bench,
    completion,
)  # fmt: skip
"""Modules that each add a verb, in the order of the help."""


_SETTING = re.compile(r"(?:survey|demos|optimize)\.(\w+) is ")
"""Beginning of a message about a setting, which has the name of its option."""

_OPTIONS = {"candidates": "trials", "timestep": "timestep-ms"}
"""Options that have another name than their setting."""

_WRITING = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO)
"""Errors of writing, which name no file where a stream is written."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a verb and return the exit code; errors of the package are printed as one line."""
    _prepare_environment()
    _prepare_log()
    return run_interruptibly(partial(_run, argv))


def _run(argv: Sequence[str] | None) -> int:
    try:
        return _answer(argv)
    except RunError as error:
        return complain(f"error: {error}", FAILED)
    except (SpiralTrunkError, UsageError) as error:
        return complain(f"error: {_name_option(str(error))}", BAD_INPUT)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] in ("", "spiraltrunk"):
            raise
        return complain(f"error: {describe_missing(str(error.name))}", BAD_INPUT)
    except OSError as error:
        return _refuse(error)


def _name_option(message: str) -> str:
    """The message about a setting of a command with the option in the place of the setting's name."""
    setting = _SETTING.match(message)
    if setting is None:
        return message
    name = _OPTIONS.get(setting[1], setting[1].replace("_", "-"))
    return f"--{name} is {message[setting.end() :]}"


def _refuse(error: OSError) -> int:
    """Tell what the operating system refused: a file, a full disc behind a stream, or another resource."""
    reason = error.strerror or str(error) or type(error).__name__
    if error.filename is not None:
        allowed = "allowed: a file or folder that can be read and written"
        return complain(f"error: {error.filename!r}: {reason}; {allowed}", BAD_INPUT)
    if error.errno in _WRITING:
        return complain(f"error: cannot write: {reason}", BAD_INPUT)
    return complain(f"error: {reason}: a process, connection or resource of this computer failed; run it again", FAILED)


def _answer(argv: Sequence[str] | None) -> int:
    try:
        parser = _build_parser()
        arguments = parser.parse_args(argv)
        if not hasattr(arguments, "run"):
            parser.error("the following arguments are required: VERB")
        return put(*arguments.run(arguments))
    except SystemExit as stop:  # Help and version.
        return send(int(stop.code or 0))


@final
class _LineHandler(logging.Handler):
    """Prints log messages of the package as lines on standard error."""

    def emit(self, record: logging.LogRecord) -> None:
        complain(record.getMessage(), DONE)


def _prepare_log() -> None:
    log = logging.getLogger("spiraltrunk")
    if not log.handlers:
        log.addHandler(_LineHandler())
        log.setLevel(logging.INFO)
        log.propagate = False
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # It warns of a home folder that cannot be written.


def _prepare_environment() -> None:
    """Set variables that packages read on import: one thread for small matrices, OpenGL without a display."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if not os.environ.get("MUJOCO_GL") and not os.environ.get("DISPLAY"):
        os.environ["MUJOCO_GL"] = "egl"


def _build_parser() -> Parser:
    parser = Parser(
        prog="spiraltrunk",
        description="Design, model, simulate, measure and build logarithmic-spiral soft trunks for robot arms.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"spiraltrunk {__version__}")
    verbs = parser.add_subparsers(metavar="VERB")  # Not required, so that a wrong option is told as one.
    for verb in VERBS:
        verb.add_verb(verbs)
    parser.set_defaults(parser=parser)
    return parser
