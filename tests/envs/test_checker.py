"""Gymnasium's own checker passes every environment without a warning; vector environments run in SAME_STEP mode."""

import os
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import spiraltrunk.envs
from spiraltrunk.envs.register import IDS

SHORT = {"episode_s": 0.06}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if "Sweep" in name else name for name in IDS]
)
def test_the_checker_passes_without_a_warning(name):
    env = gymnasium.make(name).unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env, skip_render_check=True)


@pytest.mark.slow
@pytest.mark.gl
@pytest.mark.parametrize("name", IDS)
def test_the_checker_passes_every_render_mode_and_pictures(name):
    env = gymnasium.make(name, cameras=("front", "top"), picture_size=(32, 48), privileged=True).unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env)


@pytest.mark.gl
def test_pictures_are_observed_and_rendered():
    env = gymnasium.make("spiraltrunk/Grasp-v0", cameras=("front",), picture_size=(32, 48), render_mode="rgb_array")
    seen, _ = env.reset(seed=0)
    assert seen["pixels"].shape == (32, 48, 3)
    assert seen["pixels"].std() > 5.0  # Not one colour.
    assert env.render().shape == (480, 640, 3)
    env.close()
    depth = gymnasium.make("spiraltrunk/Grasp-v0", render_mode="depth_array")
    depth.reset(seed=0)
    assert depth.render().shape == (480, 640)
    assert 0.5 < np.median(depth.render()) < 10.0
    depth.close()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="there, a display is found without variables")
def test_pictures_without_a_context_are_refused_each_time():
    """In a process of its own, in which MuJoCo would abort at the second try."""
    program = """
import gymnasium, spiraltrunk.envs
from spiraltrunk.errors import MissingPackage
env = gymnasium.make("spiraltrunk/Grasp-v0", cameras="front", disable_env_checker=True)
for _ in range(2):
    try:
        env.reset(seed=0)
    except MissingPackage as error:
        print(error)
"""
    hidden = ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY")
    environ = {name: value for name, value in os.environ.items() if name not in hidden}
    ran = subprocess.run([sys.executable, "-c", program], env=environ, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    first, second = ran.stdout.splitlines()
    assert first == second
    assert first.endswith("set MUJOCO_GL=egl")


def test_what_lerobot_and_others_read_is_there():
    env = gymnasium.make("spiraltrunk/Grasp-v0", control_hz=10.0, episode_s=2.0)
    assert env.unwrapped._max_episode_steps == 20
    assert env.unwrapped.metadata["render_fps"] == 10
    assert env.spec.kwargs["control_mode"] == "delta-pose-tension"
    env.reset(seed=0)
    assert "lift it by 20 cm" in env.unwrapped.task_description
    assert spiraltrunk.envs.TrunkEnv.metadata["render_fps"] == 50


def test_a_vector_of_environments_resets_in_the_same_step():
    envs = gymnasium.make_vec(
        "spiraltrunk/Grasp-v0", num_envs=2, vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": AutoresetMode.SAME_STEP}, randomization="none", **SHORT,
    )  # fmt: skip
    envs.reset(seed=3)
    for _ in range(3):
        seen, _, terminated, truncated, info = envs.step(np.zeros(envs.action_space.shape, np.float32))
    assert not terminated.any()
    assert truncated.all()
    assert info["final_info"]["is_success"].tolist() == [False, False]
    assert info["final_info"]["world"]["seed_world"].shape == (2,)
    lasting = seen["agent_pos"][:, -1]
    assert (lasting == 0.0).all()  # The time of an observation of the next episode.
    envs.close()


@pytest.mark.slow
def test_environments_in_processes_give_the_episodes_of_one_process():
    def run(mode, **kwargs):
        envs = gymnasium.make_vec(
            "spiraltrunk/Grasp-v0", num_envs=2, vectorization_mode=mode, **SHORT,
            vector_kwargs={"autoreset_mode": AutoresetMode.SAME_STEP, **kwargs},
        )  # fmt: skip
        envs.action_space.seed(0)
        seen = [envs.reset(seed=5)[0]] + [envs.step(envs.action_space.sample())[0] for _ in range(5)]
        envs.close()
        return [part[name] for part in seen for name in ("agent_pos", "environment_state")]

    for one, other in zip(run("sync"), run("async", context="spawn"), strict=True):
        assert np.array_equal(one, other)
