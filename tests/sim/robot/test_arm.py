"""The arm: the Panda against Franka's published numbers, and arms of the user's."""

import math
from dataclasses import replace

import mink
import mujoco
import numpy as np
import pytest
from scipy.spatial import cKDTree

from spiraltrunk.control.messages import Command
from spiraltrunk.design import ArmDesign
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError
from spiraltrunk.sim import SceneOptions, SimPlant, arm_spec
from spiraltrunk.sim.robot.arm import PANDA_HOME, PANDA_LIMITS, arm_home, arm_limits
from spiraltrunk.sim.robot.arm_ik import SPEED_SHARE, ArmReach, build_arm_model
from spiraltrunk.sim.robot.mesh_decimation import FACES

# Franka Control Interface documentation, "Limits for Panda".
Q_MIN = [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]
Q_MAX = [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]
TORQUE = [87, 87, 87, 87, 12, 12, 12]


@pytest.fixture(scope="module")
def panda():
    return arm_spec(ArmDesign()).compile()


def test_the_ready_posture_puts_the_flange_where_the_table_does(panda):
    data = mujoco.MjData(panda)
    data.qpos[:] = PANDA_HOME
    mujoco.mj_forward(panda, data)
    np.testing.assert_allclose(data.site("flange").xpos, [0.3069, 0.0, 0.5903], rtol=0, atol=5e-5)
    np.testing.assert_allclose(data.site("flange").xmat.reshape(3, 3)[:, 2], [0, 0, -1], atol=1e-9)


def _shape(model, name):
    """Vertices of a geom's mesh in its body's frame, and how many faces it has."""
    geom = model.geom(name)
    mesh = model.mesh(geom.dataid[0])
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, geom.quat)
    first, count = mesh.vertadr[0], mesh.vertnum[0]
    return model.mesh_vert[first : first + count] @ rotation.reshape(3, 3).T + geom.pos, int(mesh.facenum[0])


@pytest.mark.parametrize("link", range(8))
def test_thinned_looks_lie_where_the_published_ones_do(panda, link):
    light = arm_spec(ArmDesign(), is_light=True).compile()
    seen, faces = _shape(light, f"link{link}_visual")
    published, many = _shape(panda, f"link{link}_visual")
    assert faces <= FACES < many
    np.testing.assert_allclose([seen.min(0), seen.max(0)], [published.min(0), published.max(0)], rtol=0, atol=1.5e-3)
    assert cKDTree(published).query(seen)[0].mean() < 1.5e-3  # Their vertices are 2 to 4 mm apart.


def test_thinned_looks_move_and_touch_as_the_published_arm(panda):
    light = arm_spec(ArmDesign(), is_light=True).compile()
    for name in ("body_mass", "body_inertia", "body_ipos", "dof_M0", "geom_contype"):
        np.testing.assert_array_equal(getattr(light, name), getattr(panda, name))
    for link in range(8):
        name = f"link{link}_collision"
        np.testing.assert_array_equal(_shape(light, name)[0], _shape(panda, name)[0])


def _craig(a, d, alpha, theta):
    """One row of a Denavit-Hartenberg table in Craig's convention."""
    ca, sa, ct, s = math.cos(alpha), math.sin(alpha), math.cos(theta), math.sin(theta)
    return np.array([[ct, -s, 0, a], [s * ca, ct * ca, -sa, -d * sa], [s * sa, ct * sa, ca, d * ca], [0, 0, 0, 1]])


@pytest.mark.parametrize("seed", range(5))
def test_the_flange_follows_the_published_table(panda, seed):
    right = math.pi / 2
    table = ((0, 0.333, 0), (0, 0, -right), (0, 0.316, right), (0.0825, 0, right), (-0.0825, 0.384, -right),
             (0, 0, right), (0.088, 0, right))  # fmt: skip
    q = np.random.default_rng(seed).uniform(Q_MIN, Q_MAX)
    T = np.eye(4)
    for (a, d, alpha), theta in zip(table, q, strict=True):
        T = T @ _craig(a, d, alpha, theta)
    T = T @ _craig(0, 0.107, 0, 0)
    data = mujoco.MjData(panda)
    data.qpos[:] = q
    mujoco.mj_forward(panda, data)
    np.testing.assert_allclose(data.site("flange").xpos, T[:3, 3], rtol=0, atol=1e-9)
    np.testing.assert_allclose(data.site("flange").xmat.reshape(3, 3), T[:3, :3], rtol=0, atol=1e-9)


def test_ranges_and_torques_are_the_published_ones(panda):
    np.testing.assert_allclose(panda.jnt_range, np.stack([Q_MIN, Q_MAX], axis=-1))
    assert panda.jnt_limited.all()
    np.testing.assert_allclose(panda.actuator_forcerange, np.stack([np.negative(TORQUE), TORQUE], axis=-1))
    np.testing.assert_allclose(panda.jnt_actfrcrange, np.stack([np.negative(TORQUE), TORQUE], axis=-1))


def test_limits_are_the_published_ones():
    limits = arm_limits(ArmDesign())
    np.testing.assert_allclose(limits.position, [Q_MIN, Q_MAX])
    np.testing.assert_allclose(limits.velocity, [2.175] * 4 + [2.61] * 3)
    np.testing.assert_allclose(limits.acceleration, [15, 7.5, 10, 12.5, 15, 20, 20])
    np.testing.assert_allclose(limits.jerk, [7500, 3750, 5000, 6250, 7500, 10000, 10000])
    np.testing.assert_allclose(limits.torque, TORQUE)


def test_the_arm_weighs_what_was_identified(panda):
    """Gaz et al. 2019: 16.06 kg of links 1 to 7; franka_description gives link 0 another 0.63 kg."""
    assert panda.body_mass.sum() - panda.body("link0").mass[0] == pytest.approx(16.062, abs=0.001)
    assert panda.body("link0").mass[0] == pytest.approx(0.629769)


def test_every_inertia_is_physical(panda):
    """Principal moments are positive and each is at most the sum of the others."""
    moments = np.sort(panda.body_inertia[1:], axis=1)
    assert (moments > 0).all()
    assert (moments[:, 2] <= moments[:, 0] + moments[:, 1] + 1e-9).all()


@pytest.mark.parametrize("q", [PANDA_HOME, (0.5, 0.4, -0.3, -1.5, 0.2, 2.0, 0.1)])
def test_gravity_compensation_holds_any_posture(panda, q):
    panda.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST  # As in a scene.
    data = mujoco.MjData(panda)
    data.qpos[:] = q
    data.ctrl[:] = q
    mujoco.mj_step(panda, data, 2000)
    np.testing.assert_allclose(data.qpos, q, rtol=0, atol=1e-5)


def test_only_the_flange_carries():
    with pytest.raises(DesignError, match=r"arm\.mount_site is 'hand'; allowed: flange"):
        arm_spec(ArmDesign(mount_site="hand"))


def test_home_has_a_number_per_joint():
    with pytest.raises(DesignError, match=r"arm\.home is '3 numbers'; allowed: 7 numbers"):
        arm_home(ArmDesign(home=(0.0, 1.0, 2.0)), 7)
    np.testing.assert_allclose(arm_home(ArmDesign(), 7), PANDA_HOME)
    np.testing.assert_allclose(arm_home(ArmDesign(model="mine.xml"), 6), np.zeros(6))
    np.testing.assert_allclose(arm_home(ArmDesign(home=(0.1, 0.2)), 2), [0.1, 0.2])


def test_inverse_kinematics_reaches_a_frame_within_the_speed_limit():
    reach = ArmReach(PAPER)
    q, target = reach.home, reach.T_base(reach.home)
    target[:3, 3] += [0.05, 0.20, 0.10]
    for _ in range(150):
        before, q = q, reach.follow(q, target, 0.02)
        assert (np.abs(q - before) <= 0.02 * 0.81 * PANDA_LIMITS.velocity).all()
    np.testing.assert_allclose(reach.T_base(q), target, rtol=0, atol=2e-3)


def _by_the_program(reach, q, T_world_base, dt):
    """The same step as mink solves it, limits and all."""
    model = build_arm_model(PAPER)
    configuration = mink.Configuration(model, q=q)
    frame = mink.FrameTask("trunk_base", "site", position_cost=1.0, orientation_cost=0.5, lm_damping=1e-3)
    posture = mink.PostureTask(model, cost=1e-3)
    frame.set_target(mink.SE3.from_matrix(T_world_base))
    posture.set_target(reach.home)
    limits = [mink.ConfigurationLimit(model, min_distance_from_limits=0.01)]
    velocity = mink.solve_ik(configuration, [frame, posture], dt, solver="daqp", damping=1e-6, limits=limits)
    return velocity / max(1.0, (np.abs(velocity) / (SPEED_SHARE * PANDA_LIMITS.velocity)).max()) * dt


@pytest.mark.parametrize("is_near_a_limit", [False, True])
def test_each_step_of_the_arm_solves_the_whole_program(is_near_a_limit):
    """Without the program where no limit binds, and with it where one does: mink's solution either way."""
    reach, rng, bound = ArmReach(PAPER), np.random.default_rng(3), 0
    for _ in range(20):
        q = reach.home + rng.normal(scale=0.1, size=7)
        if is_near_a_limit:
            q[3] = Q_MAX[3] - 0.02
        target = reach.T_base(reach.home + rng.normal(scale=0.3, size=7))
        reached = reach.follow(q, target, 0.02)
        np.testing.assert_allclose(reached - q, _by_the_program(reach, q, target, 0.02), rtol=0, atol=1e-9)
        bound += not reach._is_within_limits(q, reach._free_step(q))
    assert (bound > 3) == is_near_a_limit


def test_inverse_kinematics_of_a_place_out_of_reach_stays_within_the_ranges():
    reach = ArmReach(PAPER)
    q, target = reach.home, reach.T_base(reach.home)
    target[:3, 3] += [3.0, 3.0, -3.0]
    for _ in range(300):
        q = reach.follow(q, target, 0.02)
        assert np.isfinite(q).all()
        assert (q >= Q_MIN).all()
        assert (q <= Q_MAX).all()


# A user's own arm: a gantry with a wrist, hanging 1.3 m above its base.
AXES = (("slide", "1 0 0"), ("slide", "0 1 0"), ("slide", "0 0 1"), ("hinge", "0 0 1"), ("hinge", "0 1 0"),
        ("hinge", "1 0 0"))  # fmt: skip


def _mjcf(*, site="tool", drive=tuple(range(6)), actuator="position", free=False, extra=""):
    joints, motors = "", ""
    for j, (kind, axis) in enumerate(AXES):
        limits = "-180 180" if kind == "hinge" else "-1 1"
        joints += f'<joint name="j{j}" type="{kind}" axis="{axis}" range="{limits}" armature="1" damping="1"/>'
    for j in drive:
        gains = 'kp="20000" kv="400"' if actuator == "position" else ""
        motors += f'<{actuator} name="m{j}" joint="j{j}" {gains}/>'
    joints = "<freejoint/>" if free else joints
    return f"""<mujoco model="mine">
  {extra}
  <worldbody>
    <body name="carriage" pos="0.30 0 0.6" gravcomp="1" quat="0 1 0 0">
      {joints}
      <geom type="box" size=".03 .03 .03" mass="2"/>
      <site name="{site}" pos="0 0 .04"/>
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>"""


@pytest.fixture
def named(tmp_path):
    """A design whose arm is the given MJCF text."""

    def named(text, **changes):
        path = tmp_path / "arm.xml"
        path.write_text(text)
        arm = ArmDesign(**{"model": str(path), "mount_site": "tool", "roll": -math.pi / 2, **changes})
        return replace(PAPER, arm=arm)

    return named


def _miss(design):
    """How far from where it is sent the trunk's base is after 3 s [m]; infinite with a warning of the solver."""
    plant = SimPlant(design, SceneOptions(position=(0.30, 0.45, 0.60)))
    seen = plant.reset()
    target = seen.T_world_base.copy()
    target[:3, 3] += [0.05, -0.03, 0.04]
    for _ in range(150):
        seen = plant.step(Command(T_world_base=target, cable_tension=np.zeros(3)))
    assert seen.arm_position.shape == seen.arm_velocity.shape == (6,)
    return np.inf if plant.warnings else np.abs(seen.T_world_base[:3, 3] - target[:3, 3]).max()


def test_a_users_arm_carries_the_trunk_and_follows(named):
    assert _miss(named(_mjcf())) < 5e-3


def test_a_users_arm_may_measure_angles_in_degrees(named):
    """MJCF's default; the ranges above would be 180 rad otherwise."""
    model = arm_spec(named(_mjcf()).arm).compile()
    np.testing.assert_allclose(model.jnt_range[3:], np.tile([-math.pi, math.pi], (3, 1)))
    np.testing.assert_allclose(SimPlant(named(_mjcf())).model.jnt_range[3:6], model.jnt_range[3:])


def test_a_users_arm_may_have_actuators_in_another_order(named):
    assert _miss(named(_mjcf(drive=(5, 3, 1, 0, 2, 4)))) < 5e-3


@pytest.mark.filterwarnings("error")
def test_a_users_arm_may_have_a_keyframe_and_settings_of_its_own(named, tmp_path, monkeypatch, capfd):
    """The world's settings win, without a word and without MuJoCo's log in the current folder."""
    monkeypatch.chdir(tmp_path)
    extra = """
      <option timestep="0.01" integrator="Euler" gravity="0 0 -1" jacobian="sparse" o_margin="0.1">
        <flag contact="disable" energy="enable"/>
      </option>
      <size memory="3M" nuserdata="4" nuser_body="3"/>
      <visual><global offwidth="320"/><map znear="0.5"/><rgba haze="1 0 0 1"/></visual>
      <keyframe><key name="home" qpos="0 0 0 0 0 0"/></keyframe>"""
    design = named(_mjcf(extra=extra))
    model, plain = SimPlant(design).model, SimPlant(named(_mjcf())).model
    for name in ("timestep", "integrator", "gravity", "jacobian", "o_margin", "disableflags", "enableflags"):
        np.testing.assert_array_equal(getattr(model.opt, name), getattr(plain.opt, name))
    assert model.vis.map.znear == plain.vis.map.znear
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()
    assert capfd.readouterr() == ("", "")
    assert _miss(named(_mjcf(extra=extra))) < 5e-3


def test_a_users_arm_may_bring_meshes_in_a_folder(named, tmp_path):
    (tmp_path / "parts").mkdir()
    corners = "v 0 0 0\nv .05 0 0\nv 0 .05 0\nv 0 0 .05\n"
    (tmp_path / "parts" / "block.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    extra = '<compiler meshdir="parts"/><asset><mesh name="block" file="block.obj"/></asset>'
    text = _mjcf(extra=extra).replace("<site", '<geom type="mesh" mesh="block" mass=".1"/><site')
    assert _miss(named(text)) < 5e-3


def test_a_users_arm_starts_at_the_designs_home(named):
    home = (0.02, -0.03, 0.01, 0.1, 0.0, 0.0)
    seen = SimPlant(named(_mjcf(), home=home)).reset()
    np.testing.assert_allclose(seen.arm_position, home)
    with pytest.raises(DesignError, match=r"arm\.home"):
        SimPlant(named(_mjcf(), home=(0.0,)))


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (_mjcf(site="hand"), r"arm\.mount_site is 'tool'; allowed: a site of arm\.xml: hand"),
        (_mjcf(drive=(0, 1, 2, 3, 4)), "5 actuators, 6 joints.*one position actuator on each joint"),
        (_mjcf(drive=()), "0 actuators, 6 joints"),
        (_mjcf(drive=(0, 1, 2, 3, 4, 4)).replace("m4", "n4", 1), "one position actuator on each joint"),
        (_mjcf(actuator="motor"), "one position actuator on each joint"),
        (_mjcf(free=True, drive=()), "one position actuator on each joint"),
        ("<mujoco><worldbody>", "an MJCF file that MuJoCo reads"),
        ("", "an MJCF file that MuJoCo reads"),
    ],
    ids=["site", "five", "none", "twice", "motors", "free", "cut", "empty"],
)
def test_arms_that_cannot_carry_are_refused(named, text, match):
    with pytest.raises(DesignError, match=match) as caught:
        SimPlant(named(text))
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(DesignError, match=r'arm\.model is .*none\.xml.*; allowed: "panda" or the path of an MJCF file'):
        arm_spec(ArmDesign(model=str(tmp_path / "none.xml")))
