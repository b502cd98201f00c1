"""The search for the trunk that grasps best: candidates by the design rules, each evaluated by trials in simulation."""

from spiraltrunk.workflows.optimize.optimize import run_search
from spiraltrunk.workflows.optimize.search_space import SPACE, build_candidate
from spiraltrunk.workflows.optimize.settings import SearchSettings

__all__ = ["SPACE", "SearchSettings", "build_candidate", "run_search"]
