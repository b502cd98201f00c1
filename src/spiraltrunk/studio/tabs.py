"""Tabs of the page, in the order of its bar."""

from __future__ import annotations

from collections.abc import Callable

from spiraltrunk.studio.grasp.tab import GraspTab
from spiraltrunk.studio.measure.tab import MeasureTab
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.tab import Tab
from spiraltrunk.studio.shape.tab import ShapeTab

TABS: tuple[Callable[[Page], Tab], ...] = (ShapeTab, GraspTab, MeasureTab)
"""Constructors of the tabs."""
