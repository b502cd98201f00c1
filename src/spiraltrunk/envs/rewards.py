"""Rewards: progress of a job term by term, from the simulator's true state."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import final

import numpy as np

from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.sim.ground_truth import Sample, as_slice
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.robot.trunk import section_name
from spiraltrunk.workflows.grasp.verdict.moments import Referee
from spiraltrunk.workflows.grasp.verdict.push_loss import GATE

NEARNESS = 5.0
"""Decay of nearness with distance [1/m] (ours): 1 - tanh(5 d) is 0.5 at 11 cm."""

SUCCESS, FAULT = 1.0, -0.5
"""Reward of a success, and of a fault that ends the episode [-] (ours)."""

Terms = dict[str, float]
"""Name and value of each term [-]."""


class Progress(ABC):
    """Progress of a job: terms from 0 to 1 whose weighted mean is the potential of the dense reward.

    The dense reward of a step is the change of the potential (Ng, Harada and Russell 1999: such a reward leaves the
    best policy as it is), plus `SUCCESS` or `FAULT` at the end. Over an episode it sums to the progress made.
    """

    weights: Mapping[str, float]
    """Name and weight of each term [-]."""

    def __init__(self, machine: SimMachine) -> None:
        self._data = machine.data
        self._object = machine.model.body("object").id
        self._sections = as_slice([machine.model.body(section_name(n)).id for n in range(machine.design.n_section)])
        self._radius = machine.options.shape.width / 2
        self._total = sum(self.weights.values())
        self.task: Task = machine.task
        """The task."""

    @abstractmethod
    def measure(self, first: Sample, sample: Sample, referee: Referee) -> Terms:
        """Each term at a sample, 0 to 1; ``first`` is the episode's first sample."""

    def potential(self, terms: Terms) -> float:
        """Weighted mean of the terms, 0 to 1 [-]."""
        return sum(weight * terms[name] for name, weight in self.weights.items()) / self._total

    def nearness(self) -> float:
        """1 where the trunk is at the object, falling to 0 with the distance of its nearest section."""
        offsets = (self._data.xpos[self._sections] - self._data.xpos[self._object]).tolist()
        distance = math.sqrt(min(x * x + y * y + z * z for x, y, z in offsets))
        return 1.0 - math.tanh(NEARNESS * max(distance - self._radius, 0.0))


@final
class GraspProgress(Progress):
    """Progress of a grasp: near the object, bearing it, lift, carry, hold, place and release."""

    weights: Mapping[str, float] = {
        "near": 0.5, "bear": 0.5, "lift": 1.0, "carry": 1.0, "hold": 1.0, "place": 1.0, "release": 1.0,
    }  # fmt: skip

    def __init__(self, machine: SimMachine) -> None:
        super().__init__(machine)
        self._weight = machine.task.target.mass * GRAVITY
        self._aside = max(float(np.linalg.norm(machine.task.goal.aside)), 1e-6)

    def measure(self, first: Sample, sample: Sample, referee: Referee) -> Terms:
        """Terms of `weights`; a hold fulfils those before it."""
        reached, goal = referee.reached, self.task.goal
        is_held, is_gripped = Milestone.HELD in reached, sample.grip_force > 0.0
        terms = dict.fromkeys(self.weights, 1.0 if is_held else 0.0)
        terms["near"] = 1.0 if is_held else self.nearness()
        terms["place"] = terms["release"] = 0.0
        if is_held:
            distance = float(np.linalg.norm(sample.object_position - goal.place))
            terms["place"] = 1.0 - math.tanh(NEARNESS * distance)
            terms["release"] = float(Milestone.RELEASED in reached and not is_gripped)
        elif is_gripped:
            borne = 0.0 if sample.touches_table else 1.0 - min(sample.string_tension / self._weight, 1.0)
            terms["bear"] = borne
            terms["lift"] = min(max(referee.rise / goal.lift, 0.0), 1.0)
            if Milestone.LIFTED in reached:
                terms["carry"] = min(referee.way_aside / self._aside, 1.0)
                if Milestone.CARRIED in reached:
                    terms["hold"] = min(referee.held_time / goal.hold, 1.0)
        return terms


@final
class KickProgress(Progress):
    """Progress of a kick: near the object, touched, its way towards the goal's line, straight, and at rest beyond."""

    weights: Mapping[str, float] = {"near": 0.5, "touch": 0.5, "way": 2.0, "straight": 0.5, "rest": 0.5}

    def __init__(self, machine: SimMachine) -> None:
        super().__init__(machine)
        way = (machine.task.goal.place - machine.task.target.position)[:2]
        self._line = float(np.hypot(*way))
        self._along = way / self._line

    def measure(self, first: Sample, sample: Sample, referee: Referee) -> Terms:
        """Terms of `weights`."""
        x, y = (sample.object_position - first.object_position)[:2].tolist()
        along = self._along[0] * x + self._along[1] * y
        aside = abs(self._along[1] * x - self._along[0] * y)
        share = min(max(along / self._line, 0.0), 1.0)
        angle = math.atan2(aside, max(along, 1e-9))
        is_touched = Milestone.TOUCHED in referee.reached
        return {
            "near": 1.0 if is_touched else self.nearness(),
            "touch": float(is_touched),
            "way": share,
            "straight": share * max(0.0, 1.0 - angle / GATE),
            "rest": float(share >= 1.0 and referee.is_at_rest()),
        }


@final
class SweepProgress(Progress):
    """Progress of a sweep: the way to the place, rest in its zone, then the grasp."""

    weights: Mapping[str, float] = {"near": 0.5, "push": 2.0, "zone": 1.0, "grasp": 3.0}

    def __init__(self, machine: SimMachine) -> None:
        super().__init__(machine)
        self._grasp = GraspProgress(machine)

    def measure(self, first: Sample, sample: Sample, referee: Referee) -> Terms:
        """Terms of `weights`; the grasp's are in one."""
        goal = self.task.goal
        is_lifted = Milestone.LIFTED in referee.reached
        start = math.dist(first.object_position[:2], goal.place[:2])
        distance = math.dist(sample.object_position[:2], goal.place[:2])
        is_there = distance <= goal.zone and Milestone.PUSHED in referee.reached
        grasp = self._grasp.measure(first, sample, referee)
        share = self._grasp.potential(grasp) if is_there or is_lifted else 0.0
        return {
            "near": grasp["near"],
            "push": 1.0 if is_lifted else min(max(1.0 - distance / max(start, 1e-6), 0.0), 1.0),
            "zone": float(is_there or is_lifted),
            "grasp": share,
        }


PROGRESS: Mapping[str, type[Progress]] = {"grasp": GraspProgress, "kick": KickProgress, "sweep": SweepProgress}
"""Progress of each job."""
