"""Fake trials for the survey."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from spiraltrunk.workflows.survey.plan import SurveyPlan

FAKES = Path(__file__).parent / "fakes"


@pytest.fixture(scope="session")
def fakes() -> Iterator[ModuleType]:
    """A module that processes find as well, as they start with this one's path."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(FAKES)
        yield importlib.import_module("survey_fakes")


@pytest.fixture(scope="session")
def plan() -> SurveyPlan:
    return SurveyPlan(objects={"wrap-vertical": ("cylinder-60", "ball-80"), "kick": ("box-60",)}, trials=5, seed=7)
