"""Compilation of the models in a process of its own, once after they were installed or changed."""

from __future__ import annotations

from collections.abc import Callable

from spiraltrunk.design import TrunkDesign


def compile_models(report: Callable[[str], None], design: TrunkDesign) -> None:
    """Call each model once; their machine code is then kept on disc.

    Args:
        report: called with the model that is compiled now.
        design: the trunk, whose friction decides on the kernels.
    """
    from spiraltrunk.studio.shape.state import TrunkState

    report("static equilibrium (1 of 3)")
    state = TrunkState(design)
    state.solve()
    report("the paper's model (2 of 3)")
    state.compare()
    report("inverse model (3 of 3)")
    state.reach(state.tip, is_final=False)
