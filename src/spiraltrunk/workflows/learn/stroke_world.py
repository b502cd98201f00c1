"""Worlds in which a stroke is learned: up to its choice, then one stroke, evaluated by the verdict on a kick.

A world is simulated up to the moment of the choice once. Every try of a stroke is then made by a copy of the process,
so that the state before it stays as it was.
"""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.loop import RunLog
from spiraltrunk.control.messages import Observation
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import RunError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.strategies.moves import advance, base_position, insert_next
from spiraltrunk.strategies.policy.stroke_strategy import (
    INPUTS,
    OUTPUTS,
    StrokeStrategy,
    describe_scene,
    plan_moves,
    plan_stroke,
)
from spiraltrunk.strategies.push.push_strategy import PushState
from spiraltrunk.workflows.grasp.trial import build_plant
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.push_loss import GATE, compute_path
from spiraltrunk.workflows.grasp.verdict.push_verdict import evaluate_kick
from spiraltrunk.workflows.grasp.world import draw_scene

REST_TIME, REST_WAY = 0.3, 0.001
"""An object that has moved by less in that time after the stroke is at rest: the try ends [s, m] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Outcome of one stroke."""

    reward: float
    """Dense reward: progress towards the line, less what speaks against a success, and 2 for a success [-]."""
    is_success: bool
    """Whether the verdict on a kick was a success."""
    reason: str
    """Its reason."""


@final
class StrokeWorld:
    """A drawn world, simulated up to the choice of the stroke.

    Args:
        design: the trunk.
        object_name: the object.
        strategy: the strategy whose moves lead there.
        seed: seed of the scene.
        timestep: time step of the physics [s]; None for the usual one.
    """

    def __init__(
        self, design: TrunkDesign, object_name: str, strategy: StrokeStrategy, seed: int, timestep: float | None = None
    ) -> None:
        scene = draw_scene(parse_object(object_name), seed, strategy=strategy)
        self._plant = build_plant(design, scene if timestep is None else replace(scene, timestep=timestep), strategy)
        self._strategy = strategy
        observation = self._first = self._plant.reset()
        state = strategy.init(observation)
        while not (state.sequence.is_last and strategy.has_ended(state, observation)):
            state, command = strategy.step(state, observation)
            observation = self._plant.step(command)
        self._state, self._observation = state, observation

    @property
    def inputs(self) -> np.ndarray:
        """What the network takes at the choice, shape (12,), in SI units."""
        return describe_scene(self._state.pose, self._observation)

    def strike(self, chosen: np.ndarray) -> Outcome:
        """Outcome of a stroke, numbers from -1 to 1 of shape (6,), tried in a copy of the process.

        Raises:
            RunError: where the copy ended without an outcome.
        """
        read, write = os.pipe()
        child = os.fork()
        if child == 0:
            _answer(write, lambda: self._strike(chosen))
        os.close(write)
        with os.fdopen(read, "rb") as file:
            text = file.read()
        os.waitpid(child, 0)
        if not text:
            raise RunError("the try of a stroke ended without an outcome")
        return Outcome(**json.loads(text))

    def _strike(self, chosen: np.ndarray) -> Outcome:
        pose, observation, plant = self._state.pose, self._observation, self._plant
        here = base_position(self._state.sequence, observation.time)
        moves = plan_moves(pose, plan_stroke(chosen, pose, observation), here)
        sequence = advance(insert_next(self._state.sequence, moves), observation.time)
        state: PushState = replace(self._state, sequence=sequence)
        try:
            while not _is_over(state, observation, plant.trace):
                if self._strategy.has_ended(state, observation):
                    state = replace(state, sequence=advance(state.sequence, observation.time))
                observation = plant.step(self._strategy.command(state, observation))
        except RunError as error:
            return Outcome(reward=-1.0, is_success=False, reason=str(error))
        log = RunLog(observations=(self._first,), commands=(), statuses=(), gave_up=None)
        return measure_outcome(Evidence.from_run(plant, log))


def measure_outcome(evidence: Evidence) -> Outcome:
    """Reward and verdict of a stroke."""
    verdict, (along, aside, line) = evaluate_kick(evidence), compute_path(evidence)
    furthest = int(np.argmax(along))
    angle = math.atan2(abs(float(aside[furthest])), max(float(along[furthest]), 1e-3))
    moved = float(np.hypot(along, aside).max())
    progress = float(np.clip(along.max() / line, -0.2, 1.0))
    off = min(angle / GATE, 2.0) * min(1.0, moved / 0.05)
    other = not verdict.success and not verdict.reason.startswith("went")
    reward = progress - 0.3 * off - 0.5 * other + 2.0 * verdict.success
    return Outcome(reward=reward, is_success=bool(verdict.success), reason=verdict.reason)


def _is_over(state: PushState, observation: Observation, trace: Any) -> bool:
    """Whether the last move has ended, or the object rests after the stroke; the arm's rise is then left out."""
    sequence = state.sequence
    if sequence.is_last and observation.time >= sequence.since + sequence.move.duration:
        return True
    part = [s.object_position for s in trace[-round(REST_TIME / CONTROL_PERIOD) - 1 :]]
    is_still = float(np.ptp(part, axis=0).max()) < REST_WAY
    return is_still and sequence.move.phase == "release" and observation.time > sequence.since + REST_TIME


def _answer(write: int, work: Any) -> None:
    """In the copy of the process: write the outcome and end, whatever happens."""
    try:
        outcome = work()
        with os.fdopen(write, "wb") as file:
            file.write(json.dumps(vars(outcome)).encode())
    finally:
        os._exit(0)


N_INPUT, N_OUTPUT = len(INPUTS), len(OUTPUTS)
"""Sizes of what the network takes and gives."""
