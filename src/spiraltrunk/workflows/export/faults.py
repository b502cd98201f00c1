"""Reasons for which the parts of a design cannot be made, found from their definitions in about a second."""

from __future__ import annotations

from collections.abc import Callable

from spiraltrunk.cad.checks.assembly import check_hardware
from spiraltrunk.cad.checks.self_collision import check_curl
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.output.catalogue import GROUPS
from spiraltrunk.design.drum import size_drum
from spiraltrunk.design.schema import as_typed
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, PartError


def find_faults(design: TrunkDesign, options: MakeOptions | None = None) -> tuple[str, ...]:
    """What an export of all parts would refuse, one line each, without making a part.

    Checked are the overlap of the curled trunk, the drums beside their motors, the definition of each group of parts,
    and, where all groups can be defined, the places of screws and nuts. The solids' own checks (walls, volumes) are
    made by an export alone.

    Args:
        design: the robot.
        options: how parts are made.
    """
    options = MakeOptions() if options is None else options
    parts: list[Part] = []
    checks: list[Callable[[], object]] = [lambda: check_curl(design), lambda: size_drum(design, options.drum)]
    checks += [lambda build=build: parts.extend(build(design, options)) for build in GROUPS.values()]  # type: ignore[misc]
    faults = [fault for fault in map(_try, checks) if fault]
    if not faults:
        faults = [fault for fault in [_try(lambda: check_hardware(design, options, parts))] if fault]
    return tuple(dict.fromkeys(faults))


def _try(check: Callable[[], object]) -> str:
    """Fault that a check refuses a design for; empty where it passes."""
    try:
        check()
    except DesignError as error:
        return str(as_typed(error))
    except PartError as error:
        return str(error)
    return ""
