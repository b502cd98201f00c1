"""Environment of a job of trunk and arm, after Gymnasium's interface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import NoneType
from typing import Any, final

import gymnasium
import numpy as np

from spiraltrunk.checks import check_number, check_type
from spiraltrunk.control.encoding import (
    EncodedAction,
    Setpoint,
    encode_agent,
    encode_environment,
    parse_control_mode,
    read_periods,
)
from spiraltrunk.control.loop import LONGEST
from spiraltrunk.control.messages import Command, Observation, Task
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.design.toml import load_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.envs.env_state import EnvState, check_state
from spiraltrunk.envs.episode import Episode, EpisodeRules
from spiraltrunk.envs.observing.privileged import encode_privileged
from spiraltrunk.envs.observing.spaces import (
    build_action_space,
    build_observation_space,
    check_name,
    read_cameras,
    read_size,
)
from spiraltrunk.envs.randomization import Randomization, parse_randomization
from spiraltrunk.envs.worlds import (
    World,
    WorldKey,
    check_strategy,
    describe_task,
    describe_world,
    draw_key,
    draw_world,
    read_objects,
)
from spiraltrunk.errors import RunError
from spiraltrunk.sim.mujoco_log import quiet_steps
from spiraltrunk.sim.photographer import Photographer, check_cameras
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.robot.arm_joints import build_arm_joints
from spiraltrunk.sim.scene.options import TIMESTEP, check_timestep
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict
from spiraltrunk.workflows.grasp.verdict.jobs import JOBS

REWARDS = ("dense", "sparse")
"""Modes of the reward."""

STRATEGIES: Mapping[tuple[str, str], str] = {
    ("grasp", "hung"): "wrap-vertical", ("grasp", "ground"): "wrap-horizontal", ("kick", "ground"): "kick",
    ("sweep", "ground"): "sweep",
}  # fmt: skip
"""Strategy whose scene is drawn, of each job and stage."""

RENDER_SIZE = (480, 640)
"""Height and width of what `render` returns [pixels]."""

NO_WORLD = "the environment has no world before its first reset; allowed: reset, then this"
"""What an environment says where it has drawn none."""

Dictionary = dict[str, Any]


@final
class TrunkEnv(gymnasium.Env[Dictionary, np.ndarray]):
    """A trunk on an arm that grasps, kicks or sweeps an object, in simulation.

    Worlds are drawn as trials of the survey are, and judged by its verdict. Commands pass through the control modes and
    the set points of `control.encoding`, which bound the acceleration of the arm. An episode is truncated after
    ``episode_s``; it terminates with a success, and with a fault that no success can follow.

    Args:
        job: "grasp", "kick" or "sweep".
        stage: what supports the object: "hung", or "ground"; of kick and sweep, "ground".
        strategy: strategy whose scenes are drawn; None takes `STRATEGIES`.
        object: object or objects, one of which is drawn for each world: catalogue names, measures, files, or "everyday"
            for drawn solids; None takes the strategy's first one.
        design: the robot: a preset, a TOML file, or a design.
        control_mode: what an action sets, one of `control.encoding.ControlMode`.
        control_hz: actions in a second, of which 50 is a whole multiple [1/s].
        episode_s: simulated time after which an episode is truncated [s].
        reward_mode: "dense" for the change of a potential, or "sparse" for 1 at a success.
        ends: whether an episode terminates before its time.
        randomization: how far worlds differ from what is announced: see `randomization.parse_randomization`.
        timestep: time step of the physics, as surveys take it [s].
        camera: whether a camera observes the object; None leaves it to the strategy, as trials do.
        privileged: whether observations tell the truth of object and world.
        cameras: names of the cameras whose pictures are observed.
        picture_size: height and width of these pictures [pixels].
        shadows: whether pictures show shadows.
        render_mode: "rgb_array", "depth_array" or None.

    Raises:
        UnknownName: for a name that does not exist; it lists the names.
        DesignError: for a value that is not allowed.
    """

    metadata: Dictionary = {"render_modes": ["rgb_array", "depth_array"], "render_fps": 50}  # noqa: RUF012

    def __init__(
        self,
        *,
        job: str = "grasp",
        stage: str = "hung",
        strategy: str | None = None,
        object: str | Sequence[str] | None = None,
        design: str | TrunkDesign = "paper",
        control_mode: str = "delta-pose-tension",
        control_hz: float = 50.0,
        episode_s: float = 60.0,
        reward_mode: str = "dense",
        ends: bool = True,
        randomization: Randomization = "default",
        timestep: float = TIMESTEP,
        camera: bool | None = None,
        privileged: bool = False,
        cameras: str | Sequence[str] = (),
        picture_size: Sequence[int] = (96, 96),
        shadows: bool = False,
        render_mode: str | None = None,
    ) -> None:
        self.job, self._stage = check_name("job", job, JOBS), stage
        """What counts as success: "grasp", "kick" or "sweep"."""
        check_name(f"stage of a {job}", stage, [each for known, each in STRATEGIES if known == job])
        self.design = design if isinstance(design, TrunkDesign) else load_design(design)
        """The robot."""
        self._strategy = STRATEGIES[job, stage] if strategy is None else strategy
        self._objects = read_objects(object, self._strategy)
        check_strategy(self._strategy, self.design, job, stage)
        mode, periods = parse_control_mode(control_mode), read_periods(control_hz)
        check_number("episode_s", episode_s, least=CONTROL_PERIOD, most=LONGEST)
        self._spread = parse_randomization(randomization)
        check_timestep("timestep", timestep)
        for name, value in (("ends", ends), ("privileged", privileged), ("shadows", shadows)):
            check_type(name, value, bool)
        check_type("camera", camera, (bool, NoneType))
        self._has_camera, self._is_privileged, self._has_shadows, self._timestep = camera, privileged, shadows, timestep
        self._set_pictures(cameras, picture_size, render_mode)
        self.metadata = {**self.metadata, "render_fps": round(1 / (CONTROL_PERIOD * periods))}
        self._max_episode_steps = max(1, round(episode_s / (CONTROL_PERIOD * periods)))
        self._arguments = {
            "job": job, "stage": stage, "control_mode": mode.value, "control_hz": control_hz, "episode_s": episode_s,
            "reward_mode": reward_mode, "ends": ends, "timestep": timestep, "camera": camera,
            "randomization": self._spread, "design": self.design,
        }  # fmt: skip
        reach = ArmReach(self.design)
        self._rules = EpisodeRules(
            job=job, mode=mode, arm=build_arm_joints(reach), periods=periods, most_steps=self._max_episode_steps,
            is_dense=check_name("reward mode", reward_mode, REWARDS) == "dense", ends=ends,
        )  # fmt: skip
        self.action_space = build_action_space(mode, self.design, reach.home.size)
        self.observation_space = build_observation_space(
            self.design, reach.home.size, is_privileged=self._is_privileged, cameras=self._cameras, size=self._size
        )
        self._world: World | None = None
        self._plant: SimPlant | None = None
        self._episode: Episode | None = None
        self._photographers: dict[tuple[int, int], Photographer] = {}

    def _set_pictures(self, cameras: str | Sequence[str], size: Sequence[int], render_mode: str | None) -> None:
        """Check and keep what is observed in pictures and what `render` returns."""
        self._cameras, self._size = read_cameras(cameras), read_size(size)
        check_cameras(self._cameras, self._size)
        if render_mode is not None:
            check_name("render mode", render_mode, self.metadata["render_modes"])
        self.render_mode = render_mode

    @property
    def plant(self) -> SimPlant:
        """The simulated plant, with the truth; it changes with the world."""
        return self._present.plant

    @property
    def task(self) -> Task:
        """The task of the present world."""
        return self.plant.task

    @property
    def world(self) -> Dictionary:
        """The present world in plain values."""
        if self._world is None:
            raise RunError(NO_WORLD)
        return describe_world(self._world)

    @property
    def observation(self) -> Observation:
        """The last observation as strategies get it."""
        return self._present.observation

    @property
    def setpoint(self) -> Setpoint:
        """The last command, from which actions displace the base."""
        return self._present.setpoint

    @property
    def _present(self) -> Episode:
        if self._episode is None:
            raise RunError(NO_WORLD)
        return self._episode

    @property
    def task_description(self) -> str:
        """The task in words, for policies that read."""
        if self._episode is None:
            return f"{self.job} the object with the spiral trunk"
        return describe_task(self.task, self.job)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Dictionary, Dictionary]:
        """Draw a world and begin an episode in it.

        Args:
            seed: seed of the generator of worlds; None goes on drawing.
            options: "object", "seed_world" and "strategy" of the world, which repeat a trial of the survey.

        Raises:
            UnknownName: for an option, object or strategy that does not exist.
            DesignError: for a value that is not allowed.
        """
        super().reset(seed=seed)
        key = draw_key(self.np_random, self._objects, self._strategy, options)
        if self._world is None or self._world.key != key:
            self._build(self._draw(key))
        assert self._plant is not None
        with quiet_steps():
            self._episode = Episode(self._plant, self._rules)
        return self._encode(), {"is_success": False, "success": False, "world": self.world, "time_s": 0.0}

    def step(self, action: np.ndarray) -> tuple[Dictionary, float, bool, bool, Dictionary]:
        """Follow an action for its control periods.

        Raises:
            RunError: before the first reset, and after the end of an episode.
            ModelError: for an action of another size, or that is not finite.
        """
        return self._advance(np.asarray(action), None)

    def step_command(self, command: Command) -> tuple[Dictionary, float, bool, bool, Dictionary]:
        """`step` with a command as strategies give it, which takes effect as it is.

        Raises:
            RunError: as `step`, and for a command that is refused.
        """
        return self._advance(None, command)

    def encode_command(self, command: Command) -> EncodedAction:
        """The action whose next command is the given one, and what it leaves out."""
        return self._present.encode_command(command)

    def verdict(self) -> Verdict:
        """The survey's verdict on the episode so far."""
        return self._present.verdict()

    def render(self) -> np.ndarray | None:
        """Picture of the front camera: colours, shape (480, 640, 3), or distances, shape (480, 640) [m].

        Raises:
            RunError: before the first reset.
            MissingPackage: where no OpenGL is found.
        """
        if self.render_mode is None:
            return None
        camera = self._photographer(RENDER_SIZE)
        return camera.take("front") if self.render_mode == "rgb_array" else camera.take_depth("front")

    def close(self) -> None:
        """Free the pictures' OpenGL contexts."""
        for photographer in self._photographers.values():
            photographer.close()
        self._photographers.clear()

    def get_state(self) -> EnvState:
        """Everything that the next steps depend on.

        Raises:
            RunError: before the first reset.
        """
        episode = self._present.get_state()
        assert self._world is not None
        generator = self.np_random.bit_generator.state
        return EnvState(arguments=self._arguments, world=self._world, episode=episode, generator=generator)

    def set_state(self, state: EnvState) -> None:
        """Go on from a state of an environment that was made with the same arguments.

        Raises:
            DesignError: for a state of another environment, and for anything but a state.
        """
        check_state(state, self._arguments)
        if self._world is None or self._world.key != state.world.key:
            self._build(state.world)
        assert self._plant is not None
        with quiet_steps():
            self._episode = Episode(self._plant, self._rules)
            self._episode.set_state(state.episode)
        self.np_random.bit_generator.state = state.generator

    def observe(self) -> Dictionary:
        """The present observation, as `step` returned it."""
        return self._encode()

    def _draw(self, key: WorldKey) -> World:
        return draw_world(
            key, self.design, job=self.job, stage=self._stage, spread=self._spread, has_camera=self._has_camera,
            timestep=self._timestep,
        )  # fmt: skip

    def _build(self, world: World) -> None:
        self.close()
        self._plant, self._world = SimPlant(self.design, world.scene), world

    def _advance(
        self, action: np.ndarray | None, command: Command | None
    ) -> tuple[Dictionary, float, bool, bool, Dictionary]:
        with quiet_steps():
            outcome = self._present.follow(action, command)
        info = outcome.info
        if outcome.is_terminated or outcome.is_truncated:
            info["world"] = self.world
        return self._encode(), outcome.reward, outcome.is_terminated, outcome.is_truncated, info

    def _encode(self) -> Dictionary:
        values: Dictionary = {
            "agent_pos": encode_agent(self.observation, self.setpoint.command),
            "environment_state": encode_environment(self.observation),
        }
        if self._is_privileged:
            values["privileged"] = encode_privileged(self.plant)
        if self._cameras:
            photographer = self._photographer(self._size)
            pictures = {name: photographer.take(name) for name in self._cameras}
            values["pixels"] = pictures if len(pictures) > 1 else pictures[self._cameras[0]]
        return values

    def _photographer(self, size: tuple[int, int]) -> Photographer:
        if size not in self._photographers:
            self._photographers[size] = Photographer(self.plant, size, has_shadows=self._has_shadows)
        return self._photographers[size]
