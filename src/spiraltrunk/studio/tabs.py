"""Tabs of the page, in the order of its bar."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from spiraltrunk.studio.design.tab import DesignTab
from spiraltrunk.studio.grasp.tab import GraspTab
from spiraltrunk.studio.measure.tab import MeasureTab
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.tab import Tab
from spiraltrunk.studio.robot.hub import RobotHub
from spiraltrunk.studio.robot.tab import RobotTab
from spiraltrunk.studio.shape.tab import ShapeTab

TABS: tuple[Callable[[Page], Tab], ...] = (DesignTab, ShapeTab, GraspTab, MeasureTab)
"""Constructors of the tabs but that of the robot."""


def build_tabs(hub: RobotHub) -> tuple[Callable[[Page], Tab], ...]:
    """Constructors of all tabs; all pages share the robot of the hub."""
    return (*TABS, partial(RobotTab, hub=hub))
