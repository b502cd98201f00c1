"""Control: messages, the interfaces of strategy and plant, and the control loop."""

from spiraltrunk.control.loop import RunLog, run
from spiraltrunk.control.messages import CameraObservation, Command, Goal, Observation, Target, Task
from spiraltrunk.control.plant import Plant
from spiraltrunk.control.strategy import Milestone, Status, Strategy

__all__ = [
    "CameraObservation",
    "Command",
    "Goal",
    "Milestone",
    "Observation",
    "Plant",
    "RunLog",
    "Status",
    "Strategy",
    "Target",
    "Task",
    "run",
]
