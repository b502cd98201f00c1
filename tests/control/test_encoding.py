"""Encoding: actions and commands are inverse to one another, observations stay in finite boxes with a name a number."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.control.encoding import (
    ArmJoints,
    ControlMode,
    action_names,
    action_size,
    agent_bounds,
    agent_names,
    begin_setpoint,
    decode_action,
    decode_joints,
    encode_agent,
    encode_command,
    encode_environment,
    environment_bounds,
    environment_names,
    follow_action,
    interpolate_command,
    parse_control_mode,
)
from spiraltrunk.control.messages import CameraObservation, Command, Goal, Observation, Target, Task
from spiraltrunk.design import presets
from spiraltrunk.errors import ModelError, UnknownName

DESIGN = presets.PAPER
SHIFT = np.array([0.1, 0.0, 0.05])


def frame(position=(0.4, 0.1, 1.0), turn=(0.1, -0.4, 0.3)):
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = position, Rotation.from_rotvec(turn).as_matrix()
    return T


ARM = ArmJoints(low=np.full(7, -2.0), high=np.full(7, 3.0), T_base=lambda q: frame(position=q[:3], turn=q[3:6]))


def task(axis=(0.6, 0.8, 0.0), kind="cylinder", ground=None):
    target = Target(
        kind=kind, width=0.06, length=0.24, mass=0.25, position=np.array([0.45, 0.1, 0.85]), axis=np.array(axis)
    )
    goal = Goal(aside=np.array([0.0, 0.2, 0.0]), place=np.array([0.45, 0.45, 0.93]), ground=ground)
    return Task(design=DESIGN, target=target, goal=goal)


def observe(**changes):
    seen = Observation(
        time=1.5, task=task(), T_world_base=frame(), arm_position=np.linspace(-1, 1, 7), arm_velocity=np.zeros(7),
        cable_pull=np.array([-0.01, 0.02, 0.03]), cable_tension=np.array([0.1, 20.0, 21.0]),
        base_force=np.array([0.0, 1.0, -5.0]), base_torque=np.array([0.1, 0.2, 0.3]),
    )  # fmt: skip
    return replace(seen, **changes)


def command(**changes):
    pull = np.array([np.inf, 0.05, 0.06])
    return replace(
        Command(T_world_base=frame(), cable_tension=np.array([0.0, 30.0, 60.0]), cable_pull=pull, gripper=-0.5),
        **changes,
    )


@pytest.mark.parametrize("mode", ControlMode)
def test_the_action_of_a_decoded_command_is_the_action(mode):
    rng = np.random.default_rng(3)
    before = command()
    for _ in range(20):
        action = rng.uniform(-0.9, 0.9, action_size(mode, DESIGN))
        decoded = decode_action(mode, action, before, task(), arm=ARM)
        if mode is ControlMode.POSE_TENSION or mode is ControlMode.POSE_TENSION_PULL:
            action[3:6] *= 0.5  # A rotation vector of more than half a turn is another one.
            decoded = decode_action(mode, action, before, task(), arm=ARM)
        joints = decode_joints(action, ARM)
        encoded = encode_command(mode, decoded, before, task(), arm=ARM, arm_position=joints)
        assert np.abs(encoded.action - action).max() < 1e-6
        assert encoded.clipped == 0.0
        before = decoded


@pytest.mark.parametrize("mode", [mode for mode in ControlMode if not mode.sets_joints])
def test_a_command_comes_back_from_its_action(mode):
    before, wanted = command(), command(T_world_base=frame(position=(0.41, 0.095, 1.0), turn=(0.11, -0.39, 0.3)))
    encoded = encode_command(mode, wanted, before, task())
    decoded = decode_action(mode, encoded.action, before, task())
    assert np.abs(decoded.T_world_base - wanted.T_world_base).max() < 1e-6
    assert decoded.gripper == wanted.gripper
    if mode.sets_tension:
        assert np.abs(decoded.cable_tension - wanted.cable_tension).max() < 1e-5
    if mode.sets_pull:
        assert decoded.cable_pull[0] == np.inf
        assert np.abs(decoded.cable_pull[1:] - wanted.cable_pull[1:]).max() < 1e-7
    else:
        assert decoded.cable_pull is None
    told = [
        name for name, is_set in (("cable_tension", mode.sets_tension), ("cable_pull", mode.sets_pull)) if not is_set
    ]
    assert list(encoded.dropped) == told


def test_the_inverse_tells_how_much_it_clipped():
    far = command(T_world_base=frame(position=(0.4, 0.13, 1.0)))
    encoded = encode_command(ControlMode.DELTA_POSE_TENSION, far, command(), task())
    assert encoded.action[1] == 1.0
    assert encoded.clipped == pytest.approx(0.03 / (0.6 * 0.02) - 1)


def test_a_longer_period_displaces_by_as_much_more():
    action = np.zeros(action_size(ControlMode.DELTA_POSE_TENSION, DESIGN))
    action[0] = 0.5
    moved = [
        decode_action(ControlMode.DELTA_POSE_TENSION, action, command(), task(), period=period).T_world_base[0, 3] - 0.4
        for period in (0.02, 0.1)
    ]
    assert moved == pytest.approx([0.006, 0.03])


def test_the_commanded_base_leads_the_measured_one_by_a_bounded_distance():
    action = np.zeros(action_size(ControlMode.DELTA_POSE_TENSION, DESIGN))
    action[0], now, measured = 1.0, command(), frame()
    for _ in range(100):
        now = decode_action(ControlMode.DELTA_POSE_TENSION, action, now, task(), measured=measured)
    assert np.linalg.norm(now.T_world_base[:3, 3] - measured[:3, 3]) == pytest.approx(0.15)


def test_the_absolute_pose_moves_with_the_announced_object():
    mode, action = ControlMode.POSE_TENSION, np.full(action_size(ControlMode.POSE_TENSION, DESIGN), 0.2)
    one = task()
    shifted = replace(one, target=replace(one.target, position=one.target.position + SHIFT))
    frames = [decode_action(mode, action, command(), each).T_world_base for each in (one, shifted)]
    assert np.abs(frames[1][:3, 3] - frames[0][:3, 3] - SHIFT).max() < 1e-12
    assert (frames[0][:3, :3] == frames[1][:3, :3]).all()


@pytest.mark.parametrize("mode", ControlMode)
def test_every_number_of_an_action_has_a_name(mode):
    names = action_names(mode, DESIGN)
    assert len(names) == len(set(names)) == action_size(mode, DESIGN)
    assert names[-1] == "gripper"


@pytest.mark.parametrize("wrong", [np.zeros(3), np.full(10, np.nan), np.full(10, np.inf)])
def test_a_wrong_action_is_refused(wrong):
    with pytest.raises(ModelError, match="allowed: 10 finite numbers"):
        decode_action(ControlMode.DELTA_POSE_TENSION, wrong, command(), task())


def test_joints_need_an_arm():
    with pytest.raises(ModelError, match="the joints of the arm"):
        decode_action(ControlMode.JOINT_TENSION, np.zeros(4), command(), task())


def test_an_unknown_mode_lists_the_known_ones():
    assert parse_control_mode("joint-tension") is ControlMode.JOINT_TENSION
    with pytest.raises(UnknownName, match="known: delta-pose-tension"):
        parse_control_mode("fly")


def test_commands_between_two_are_linear():
    before, after = command(), command(
        T_world_base=frame(position=(0.5, 0.1, 1.0), turn=(0.2, -0.4, 0.3)), cable_tension=np.array([0.0, 40.0, 60.0]),
        cable_pull=np.array([np.inf, 0.07, np.inf]), gripper=0.5,
    )  # fmt: skip
    half = interpolate_command(before, after, 0.5)
    assert half.T_world_base[0, 3] == pytest.approx(0.45)
    assert half.cable_tension[1] == pytest.approx(35.0)
    assert half.cable_pull.tolist() == [np.inf, pytest.approx(0.06), np.inf]
    assert half.gripper == 0.0
    assert np.linalg.det(half.T_world_base[:3, :3]) == pytest.approx(1.0)
    assert interpolate_command(before, after, 1.0) is after


def test_every_number_of_an_observation_has_a_name_and_finite_bounds():
    for values, names, (low, high) in (
        (encode_agent(observe(), command()), agent_names(DESIGN), agent_bounds(DESIGN)),
        (encode_environment(observe()), environment_names(), environment_bounds()),
    ):
        assert values.shape == low.shape == high.shape == (len(names),) == (len(set(names)),)
        assert values.dtype == low.dtype == high.dtype == np.float32
        assert np.isfinite(low).all()
        assert np.isfinite(high).all()
        assert (low < high).all()
        assert ((values >= low) & (values <= high)).all()


def test_numbers_are_where_their_names_say():
    values = dict(zip(agent_names(DESIGN), encode_agent(observe(), command(gripper=1.0)), strict=True))
    assert values["arm_position_7"] == 1.0
    assert values["base_z"] == 1.0
    assert values["cable_tension_3"] == 21.0
    assert values["base_force_z"] == -5.0
    assert values["gripper"] == 1.0
    assert values["time_share"] == pytest.approx(1.5 / 300)
    values = dict(zip(environment_names(), encode_environment(observe()), strict=True))
    assert values["target_axis_y"] == pytest.approx(0.8)
    assert values["target_is_cylinder"] == 1.0
    assert values["target_is_box"] == 0.0
    assert values["goal_lift"] == pytest.approx(0.2)
    assert values["goal_has_ground"] == 0.0


def test_values_beyond_the_bounds_are_clipped():
    values = encode_agent(observe(base_force=np.array([1e6, 0.0, 0.0])))
    assert values[agent_names(DESIGN).index("base_force_x")] == 200.0


def test_what_the_camera_has_not_seen_is_as_announced():
    names = environment_names()
    seen = [names.index(name) for name in ("seen", "seen_age_share", "seen_x", "seen_y", "seen_z")]
    assert encode_environment(observe())[seen].tolist() == pytest.approx([0.0, 0.0, 0.45, 0.1, 0.85])
    look = CameraObservation(time=1.2, position=np.array([0.4, 0.2, 0.8]), axis=np.array([1.0, 0.0, 0.0]))
    assert encode_environment(observe(camera=look))[seen].tolist() == pytest.approx([1.0, 0.3 / 300, 0.4, 0.2, 0.8])


def test_an_object_of_another_kind_is_other():
    values = dict(zip(environment_names(), encode_environment(observe(task=task(kind="solid"))), strict=True))
    assert values["target_is_other"] == 1.0


def roll(mode, actions, *, periods=1):
    """Set points of actions from the frame of `observe`, which the measured base follows."""
    seen = observe()
    setpoint, passed = begin_setpoint(seen), []
    for action in actions:
        for period in range(periods):
            setpoint = follow_action(setpoint, mode, action, seen, period=period, periods=periods)
            seen = replace(seen, T_world_base=setpoint.command.T_world_base)
            passed.append(setpoint)
    return passed


@pytest.mark.parametrize("mode", [ControlMode.DELTA_POSE_TENSION, ControlMode.POSE_TENSION])
@pytest.mark.parametrize("periods", [1, 5])
def test_set_points_of_wild_actions_accelerate_within_the_bounds(mode, periods):
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1, 1, (60, action_size(mode, DESIGN)))
    frames = np.array([each.command.T_world_base for each in roll(mode, actions, periods=periods)])
    velocity = np.diff(frames[:, :3, 3], axis=0) / 0.02
    assert np.linalg.norm(np.diff(velocity, axis=0), axis=1).max() <= 1.0 * 0.02 * (1 + 1e-9)
    turns = (Rotation.from_matrix(frames[1:, :3, :3]) * Rotation.from_matrix(frames[:-1, :3, :3]).inv()).as_rotvec()
    assert np.linalg.norm(np.diff(turns / 0.02, axis=0), axis=1).max() <= 3.5 * 0.02 * (1 + 1e-6)


@pytest.mark.parametrize("mode", [mode for mode in ControlMode if not mode.sets_joints])
def test_set_points_pass_the_smooth_path_of_a_strategy_unchanged(mode):
    seen, shares = observe(), np.linspace(0.0, 1.0, 101)
    path = 10 * shares**3 - 15 * shares**4 + 6 * shares**5
    setpoint = begin_setpoint(seen)
    for share in path[1:]:
        T = frame(position=(0.4 + 0.2 * share, 0.1, 1.0 - 0.1 * share), turn=(0.1 + 0.5 * share, -0.4, 0.3))
        wanted = command(T_world_base=T)
        action = encode_command(mode, wanted, setpoint.command, task()).action
        setpoint = follow_action(setpoint, mode, action, seen)
        seen = replace(seen, T_world_base=setpoint.command.T_world_base)
        assert np.abs(setpoint.command.T_world_base - T).max() < 1e-6


def test_an_absolute_pose_that_jumps_is_reached_without_passing_it():
    mode = ControlMode.POSE_TENSION
    action = encode_command(mode, command(T_world_base=frame(position=(0.6, 0.1, 1.0))), command(), task()).action
    x = np.array([each.command.T_world_base[0, 3] for each in roll(mode, [action] * 100)])
    assert x[-1] == pytest.approx(0.6, abs=1e-4)
    assert x.max() <= 0.6 + 0.005


def test_set_points_of_joints_are_refused():
    with pytest.raises(ModelError, match="sets the base"):
        follow_action(begin_setpoint(observe()), ControlMode.JOINT_TENSION, np.zeros(11), observe())
