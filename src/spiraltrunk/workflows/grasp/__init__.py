"""One trial: a drawn world, a strategy in it, the verdict, and the files that it leaves."""

from spiraltrunk.workflows.grasp.trial import Trial, run_trial
from spiraltrunk.workflows.grasp.world import Spread, draw_scene

__all__ = ["Spread", "Trial", "draw_scene", "run_trial"]
