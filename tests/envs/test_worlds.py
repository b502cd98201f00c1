"""Worlds, randomisation, options and what is refused."""

import gymnasium
import numpy as np
import pytest

import spiraltrunk.envs  # noqa: F401
from spiraltrunk.envs.observing.privileged import privileged_names
from spiraltrunk.envs.randomization import FACTORS, parse_randomization
from spiraltrunk.errors import DesignError, ModelError, RunError, SpiralTrunkError, UnknownName
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.workflows.grasp.world import NOISE, Spread

NAME = "spiraltrunk/Grasp-v0"


def make(name=NAME, **given):
    return gymnasium.make(name, disable_env_checker=True, **given).unwrapped


def test_nothing_is_random_without_randomisation():
    env = make(randomization="none")
    worlds = [env.reset(seed=seed)[1]["world"] for seed in (1, 2)]
    for world in worlds:
        assert world["offset_m"] == (0.0, 0.0, 0.0)
        assert world["mass_factor"] == world["size_factor"] == world["stiffness_factor"] == 1.0
        assert world["friction"] == 0.8
        assert world["delay_s"] == 0.0


def test_one_factor_is_random_by_its_name():
    env = make(randomization=("mass",))
    worlds = [env.reset(seed=seed)[1]["world"] for seed in (1, 2, 3)]
    assert len({world["mass_factor"] for world in worlds}) == 3
    assert {world["size_factor"] for world in worlds} == {1.0}


def test_randomisations_by_name_are_spreads():
    assert parse_randomization("default") == Spread()
    assert parse_randomization("sensors").sensors == NOISE
    assert parse_randomization({"friction": [0.3, 0.4], "sensors": True}) == Spread(
        position=0.0, yaw=0.0, size=0.0, mass=0.0, friction=(0.3, 0.4), stiffness=0.0, sensors=NOISE
    )
    assert parse_randomization({"sensors": False}).sensors == SensorOptions()
    assert "position" in FACTORS
    with pytest.raises(UnknownName, match="none, default, position"):
        parse_randomization("gravity")
    with pytest.raises(DesignError, match=r"spread\.mass"):
        parse_randomization({"mass": 2.0})


def test_an_object_is_drawn_from_several():
    env = make(object=("cylinder-60", "cylinder-90"), randomization="none")
    drawn = [env.reset(seed=seed)[1]["world"]["object"] for seed in range(6)]
    assert set(drawn) == {"cylinder-60", "cylinder-90"}


def test_everyday_objects_are_drawn_anew():
    env = make(stage="ground", object="everyday")
    names = [env.reset(seed=seed)[1]["world"]["object"] for seed in (0, 1)]
    assert names[0] != names[1]
    assert all(name.startswith("everyday:seed=") for name in names)


def test_objects_by_their_measures():
    env = make(object="cylinder:diameter_mm=72,height_mm=180,mass_g=350", randomization="none")
    world = env.reset(seed=0)[1]["world"]
    assert world["width_m"] == pytest.approx(0.072)
    assert world["mass_kg"] == pytest.approx(0.35)


def test_a_camera_looks_where_it_is_asked_for():
    env = make(camera=True)
    names = spiraltrunk_names()
    seen, _ = env.reset(seed=0)
    assert seen["environment_state"][names.index("seen")] == 1.0
    truth = env.plant.trace[-1].object_position
    place = seen["environment_state"][names.index("seen_x") : names.index("seen_x") + 3]
    assert 0.0 < np.linalg.norm(place - truth) < 0.004
    blind, _ = make(camera=False).reset(seed=0)
    assert blind["environment_state"][names.index("seen")] == 0.0


def spiraltrunk_names():
    from spiraltrunk.control.encoding import environment_names

    return environment_names()


def test_the_truth_is_told_only_when_asked_for():
    assert "privileged" not in make().reset(seed=0)[0]
    env = make(privileged=True)
    seen, _ = env.reset(seed=0)
    told = dict(zip(privileged_names(), seen["privileged"].tolist(), strict=True))
    assert told["true_x"] == pytest.approx(env.plant.trace[-1].object_position[0])
    assert told["true_friction"] == pytest.approx(env.world["friction"])
    for _ in range(3):
        seen = env.step(np.zeros(10))[0]
    assert seen["privileged"][privileged_names().index("string_tension")] > 1.0


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"job": "juggle"}, "unknown job 'juggle'; known: grasp, kick, sweep"),
        ({"job": "kick"}, "unknown stage of a kick 'hung'; known: ground"),
        ({"strategy": "fly"}, "unknown strategy 'fly'"),
        ({"object": "unicorn"}, "unknown object 'unicorn'"),
        ({"object": ()}, "object is"),
        ({"object": 5}, "object is 5; allowed: a text, or one or more texts"),
        ({"stage": ["hung"]}, "unknown stage of a grasp"),
        ({"strategy": "kick"}, "strategy is 'kick'; allowed: one whose job is a grasp with the support 'hung'"),
        ({"ends": "no"}, "ends is 'no'; allowed: bool"),
        ({"camera": "no"}, "camera is 'no'"),
        ({"cameras": None}, "cameras is None"),
        ({"cameras": ("top", "top")}, "each camera once"),
        ({"picture_size": 64}, "picture_size is 64; allowed: height and width"),
        ({"control_mode": "mind"}, "unknown control mode 'mind'; known: delta-pose-tension"),
        ({"timestep": 1.0}, "timestep is 1.0"),
        ({"control_hz": 30.0}, "control_hz is 30.0; allowed: 50 over a whole number"),
        ({"episode_s": 1e6}, "episode_s is 1000000.0"),
        ({"reward_mode": "kind"}, "unknown reward mode 'kind'; known: dense, sparse"),
        ({"randomization": "wild"}, "unknown randomization 'wild'"),
        ({"cameras": ("ceiling",)}, "unknown camera 'ceiling'; known: front"),
        ({"picture_size": (8, 8)}, "picture_size height is 8"),
        ({"picture_size": (8,)}, "picture_size is"),
        ({"design": "nowhere.toml"}, "design"),
    ],
)  # fmt: skip
def test_what_is_not_allowed_is_refused_with_what_is(given, text):
    from spiraltrunk.envs import TrunkEnv

    with pytest.raises(SpiralTrunkError) as refused:
        TrunkEnv(**given)
    assert text in str(refused.value)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"world": 3}, "unknown option of reset 'world'; known: object, seed_world, strategy"),
        ({"seed_world": -1}, "options['seed_world'] is -1"),
        ({"seed_world": 1.5}, "options['seed_world'] is 1.5"),
        ({"strategy": "kick"}, "strategy is 'kick'; allowed: one whose job is a grasp with the support 'hung'"),
        ({"object": "unicorn"}, "unknown object"),
        (["object"], "options is ['object']; allowed: a mapping"),
    ],
)
def test_options_of_a_reset_are_checked(options, text):
    env = make()
    env.reset(seed=0)
    before = env.world
    with pytest.raises(SpiralTrunkError) as refused:
        env.reset(options=options)
    assert text in str(refused.value)
    assert env.world == before


def test_steps_before_a_reset_and_after_the_end_are_refused():
    env = make(episode_s=0.02)
    with pytest.raises(RunError, match="before its first reset"):
        env.step(np.zeros(10))
    with pytest.raises(RunError, match="before its first reset"):
        _ = env.world
    env.reset(seed=0)
    assert env.step(np.zeros(10))[3]
    with pytest.raises(RunError, match="the episode has ended"):
        env.step(np.zeros(10))


@pytest.mark.parametrize("action", [np.zeros(3), np.full(10, np.nan), None, "left", ["a"] * 10])
def test_a_wrong_action_is_refused(action):
    env = make()
    env.reset(seed=0)
    with pytest.raises(ModelError, match="allowed: 10 finite numbers"):
        env.step(action)
