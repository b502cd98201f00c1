"""Tabs of the page, in the order of its bar.

The tab that a new page shows first is imported with this module, and each other one when it is built.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from spiraltrunk.studio.grasp.tab import GraspTab
from spiraltrunk.studio.page.later_tab import LaterTab
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.tab import Tab

if TYPE_CHECKING:
    from spiraltrunk.studio.robot.hub import RobotHub


def _load_design() -> Callable[[Page], Tab]:
    from spiraltrunk.studio.design.tab import DesignTab

    return DesignTab


def _load_shape() -> Callable[[Page], Tab]:
    from spiraltrunk.studio.shape.tab import ShapeTab

    return ShapeTab


def _load_measure() -> Callable[[Page], Tab]:
    from spiraltrunk.studio.measure.tab import MeasureTab

    return MeasureTab


TABS: tuple[Callable[[Page], Tab], ...] = (
    partial(LaterTab, title="Design", load=_load_design),
    partial(LaterTab, title="Shape", load=_load_shape),
    GraspTab,
    partial(LaterTab, title="Measure", load=_load_measure),
)
"""Constructors of the tabs but that of the robot."""


def build_tabs(open_hub: Callable[[], RobotHub]) -> tuple[Callable[[Page], Tab], ...]:
    """Constructors of all tabs; all pages share the robot of the one hub that ``open_hub`` gives."""

    def load_robot() -> Callable[[Page], Tab]:
        from spiraltrunk.studio.robot.tab import RobotTab

        return partial(RobotTab, hub=open_hub())

    return (*TABS, partial(LaterTab, title="Robot", load=load_robot))
