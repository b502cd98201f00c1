"""Strategies that push an object along the ground with the rolled trunk."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from spiraltrunk.control.messages import CameraObservation, Command, Observation
from spiraltrunk.design.rules import graspable_range
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.strategies.move_strategy import MoveState, MoveStrategy
from spiraltrunk.strategies.moves import MoveSequence, begin, fraction
from spiraltrunk.strategies.push.approach_pose import ApproachPose, reach_of, roll_up
from spiraltrunk.strategies.sensing import limit_ventral_lead, seen_position

STILL = 0.003
"""Displacement between two camera observations up to which an object is at rest [m] (ours): their errors differ by
2 mm at most."""

LOOKS = 3
"""Camera observations that show an object at rest [-] (ours): two may meet one that rocks at equal displacements."""

LEAD = 0.02
"""Lead of one ventral cable before the other, over the stroke [-] (ours)."""


@dataclass(frozen=True, kw_only=True)
class PushState(MoveState):
    """What a push remembers."""

    pose: ApproachPose
    """Pose of the rolled trunk."""
    looks: tuple[CameraObservation, ...] = ()
    """The last LOOKS camera observations, or fewer."""


State = TypeVar("State", bound=PushState)


class PushStrategy(MoveStrategy[State]):
    """A push with the rolled trunk."""

    support = "ground"
    orientation = "upright"
    needs_camera = True
    gap: float
    """Gap between the object and the rolled trunk behind it before the push [m]."""

    def widths(self, design: TrunkDesign) -> tuple[float, float]:
        """Least and greatest width that it can take [m]: anything up to what the trunk can wrap."""
        return 0.0, graspable_range(design).maximum

    def sense(self, state: State, observation: Observation) -> State:
        """Remember the camera's last observations."""
        camera = observation.camera
        if camera is None or (state.looks and camera.time <= state.looks[-1].time):
            return state
        return replace(state, looks=(*state.looks[1 - LOOKS :], camera))

    def command(self, state: State, observation: Observation) -> Command:
        """Command of the present move, the ventral cables kept together."""
        return keep_together(super().command(state, observation), state.sequence, observation)

    def roll_up(self, pose: ApproachPose, observation: Observation) -> MoveSequence:
        """Moves from the observed frame of the base that roll the trunk up and turn it into its pose."""
        return begin(roll_up(observation, pose, self.base_behind(pose, observation)), observation)

    def base_behind(self, pose: ApproachPose, observation: Observation) -> np.ndarray:
        """Position of the base behind the object as observed, shape (3,) [m]."""
        return pose.base_behind(seen_position(observation), reach_of(observation.task.target) + self.gap)


def is_still(state: PushState) -> bool:
    """Whether the object was in one place in the camera's last LOOKS observations."""
    places = np.array([look.position for look in state.looks])
    return len(places) == LOOKS and float(np.linalg.norm(places - places[-1], axis=1).max()) <= STILL


def keep_together(command: Command, sequence: MoveSequence, observation: Observation) -> Command:
    """The command with the ventral cables' pulls bounded while the trunk is rolled up.

    Held by tension alone, a rolled trunk yields out of its plane: one cable takes in what the other pays out. The bound
    tightens during the turn into the pose, so that the lagging cable catches up.
    """
    action = sequence.move.action
    if action in ("roll up", "unroll", "look over"):
        return command
    lead = 2.0 - fraction(sequence, observation.time) if action == "turn" else 1.0
    return replace(command, cable_pull=limit_ventral_lead(observation, lead * LEAD))
