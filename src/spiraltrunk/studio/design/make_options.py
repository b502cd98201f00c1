"""How the page makes parts: with the defaults, and with refusals that name the page's own controls."""

from __future__ import annotations

from spiraltrunk.cad.components.options import MakeOptions, Remedies
from spiraltrunk.studio.design.parameters import GRIPPER

_COMMAND = "set by the command export"

PAGE_OPTIONS = MakeOptions(
    remedies=Remedies(
        nozzle=f"a finer nozzle ({_COMMAND})", bed=f"a larger bed ({_COMMAND})", tall_bed=f"a taller bed ({_COMMAND})",
        tolerance=f"a finer mesh ({_COMMAND})", bare=f"{GRIPPER!r} switched off",
    )
)  # fmt: skip
"""Nozzle, bed and meshes have no control on the page; the command ``spiraltrunk export`` has options for them."""
