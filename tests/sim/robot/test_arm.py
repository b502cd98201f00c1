"""The arm: the described ones against their makers' published numbers, and arms of the user's."""

import math
from dataclasses import replace

import mink
import mujoco
import numpy as np
import pytest
from scipy.spatial import cKDTree

from spiraltrunk.control.arm_limits import find_missing_limits, standstill_margin, velocity_bounds
from spiraltrunk.control.messages import Command
from spiraltrunk.design import ArmDesign
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError
from spiraltrunk.sim import SceneOptions, SimPlant, arm_spec
from spiraltrunk.sim.robot.arm import ARMS, FACES, arm_home, arm_limits, arm_payload, check_arm
from spiraltrunk.sim.robot.arm_ik import SPEED_SHARE, ArmReach, build_arm_model
from spiraltrunk.sim.robot.panda import PANDA

RIGHT = math.pi / 2
FRANKA_DH = ((0, 0.333, 0), (0, 0, -RIGHT), (0, 0.316, RIGHT), (0.0825, 0, RIGHT), (-0.0825, 0.384, -RIGHT),
             (0, 0, RIGHT), (0.088, 0, RIGHT), (0, 0.107, 0))  # fmt: skip

# Franka Control Interface documentation, "Limits for Panda" and "Limits for Franka Research 3"; masses: Gaz et al. 2019
# and franka_description, the FR3's as MuJoCo Menagerie prints them.
PUBLISHED = {
    "panda": {
        "dh": FRANKA_DH,
        "low": [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973],
        "high": [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973],
        "velocity": [2.175] * 4 + [2.61] * 3,
        "acceleration": [15, 7.5, 10, 12.5, 15, 20, 20],
        "jerk": [7500, 3750, 5000, 6250, 7500, 10000, 10000],
        "torque": [87, 87, 87, 87, 12, 12, 12],
        "mass": [0.629769, 4.970684, 0.646926, 3.228604, 3.587895, 1.225946, 1.666555, 0.735522],
        "total": (16.062, 0.001),
    },
    "fr3": {
        "dh": FRANKA_DH,
        "low": [-2.9007, -1.8361, -2.9007, -3.0770, -2.8763, 0.4398, -3.0508],
        "high": [2.9007, 1.8361, 2.9007, -0.1169, 2.8763, 4.6216, 3.0508],
        "velocity": [2.62] * 4 + [5.26, 4.18, 5.26],
        "acceleration": [10] * 7,
        "jerk": [5000] * 7,
        "torque": [87, 87, 87, 87, 12, 12, 12],
        "mass": [2.3966, 2.92747, 2.93554, 2.2449, 2.6156, 2.32712, 1.81704, 0.627143],
        "total": (15.495, 0.001),
    },
}

NAMES = sorted(PUBLISHED)


def test_every_described_arm_is_tested():
    assert sorted(ARMS) == NAMES


@pytest.fixture(scope="module", params=NAMES)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def published(name):
    return PUBLISHED[name]


@pytest.fixture(scope="module")
def arm(name):
    return arm_spec(ArmDesign(model=name)).compile()


@pytest.fixture(scope="module")
def robot(name):
    return replace(PAPER, arm=replace(PAPER.arm, model=name))


@pytest.fixture(scope="module")
def panda():
    return arm_spec(ArmDesign()).compile()


def test_the_ready_posture_puts_the_flange_where_the_table_does(name, arm):
    data = mujoco.MjData(arm)
    data.qpos[:] = ARMS[name].home
    mujoco.mj_forward(arm, data)
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
def test_decimated_visuals_lie_where_the_published_ones_do(panda, link):
    light = arm_spec(ArmDesign(), is_decimated=True).compile()
    seen, faces = _shape(light, f"link{link}_visual")
    published, many = _shape(panda, f"link{link}_visual")
    assert faces <= FACES < many
    np.testing.assert_allclose([seen.min(0), seen.max(0)], [published.min(0), published.max(0)], rtol=0, atol=1.5e-3)
    assert cKDTree(published).query(seen)[0].mean() < 1.5e-3  # Their vertices are 2 to 4 mm apart.


def test_decimated_visuals_move_and_touch_as_the_published_arm(panda):
    light = arm_spec(ArmDesign(), is_decimated=True).compile()
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
def test_the_flange_follows_the_published_table(arm, published, seed):
    q = np.random.default_rng(seed).uniform(published["low"], published["high"])
    T = np.eye(4)
    for (a, d, alpha), theta in zip(published["dh"], [*q, 0.0], strict=True):
        T = T @ _craig(a, d, alpha, theta)
    data = mujoco.MjData(arm)
    data.qpos[:] = q
    mujoco.mj_forward(arm, data)
    np.testing.assert_allclose(data.site("flange").xpos, T[:3, 3], rtol=0, atol=1e-9)
    np.testing.assert_allclose(data.site("flange").xmat.reshape(3, 3), T[:3, :3], rtol=0, atol=1e-9)


def test_ranges_and_torques_are_the_published_ones(arm, published):
    np.testing.assert_allclose(arm.jnt_range, np.stack([published["low"], published["high"]], axis=-1))
    assert arm.jnt_limited.all()
    torque = np.stack([np.negative(published["torque"]), published["torque"]], axis=-1)
    np.testing.assert_allclose(arm.actuator_forcerange, torque)
    np.testing.assert_allclose(arm.jnt_actfrcrange, torque)


def test_limits_are_the_published_ones(name, published):
    limits = arm_limits(ArmDesign(model=name))
    np.testing.assert_allclose(limits.position, [published["low"], published["high"]])
    for quantity in ("velocity", "acceleration", "jerk", "torque"):
        np.testing.assert_allclose(getattr(limits, quantity), published[quantity])
    assert find_missing_limits(limits) == ()


def test_the_arm_weighs_what_was_identified(arm, published):
    """The links that move together, and each for itself."""
    total, error = published["total"]
    assert arm.body_mass[2:].sum() == pytest.approx(total, abs=error)
    np.testing.assert_allclose(arm.body_mass[1:], published["mass"], rtol=3e-6)


def test_every_inertia_is_physical(arm):
    """Principal moments are positive and each is at most the sum of the others."""
    moments = np.sort(arm.body_inertia[1:], axis=1)
    assert (moments > 0).all()
    assert (moments[:, 2] <= moments[:, 0] + moments[:, 1] + 1e-9).all()


def test_the_fr3_turns_as_another_model_of_it_does():
    """Principal moments and centres of links 1 to 7 as MuJoCo Menagerie has them, made from Franka's URDF."""
    moments = [
        (0.0239286, 0.0227246, 0.00610634), (0.0629567, 0.0411924, 0.0246371), (0.0267409, 0.0189869, 0.0171587),
        (0.05139, 0.0372717, 0.0160047), (0.0579335, 0.0449144, 0.0130634), (0.0175039, 0.0161123, 0.00193529),
        (0.000223836, 0.000223642, 5.64132e-07),
    ]  # fmt: skip
    centers = [
        (4.128e-07, -0.0181251, -0.0386036), (0.00318289, -0.0743222, 0.00881461), (0.0407016, -0.00482006, -0.0289731),
        (-0.0459101, 0.0630493, -0.00851879), (-0.00160396, 0.0292536, -0.0972966), (0.0597131, -0.0410295, -0.0101693),
        (0.00452258, 0.00862619, -0.0161633),
    ]  # fmt: skip
    model = arm_spec(ArmDesign(model="fr3")).compile()
    np.testing.assert_allclose(np.sort(model.body_inertia[2:], axis=1)[:, ::-1], moments, rtol=5e-6)
    np.testing.assert_allclose(model.body_ipos[2:], centers, rtol=0, atol=1e-7)


def test_the_arm_does_not_touch_itself_where_work_starts(name, arm):
    data = mujoco.MjData(arm)
    data.qpos[:] = ARMS[name].home
    mujoco.mj_forward(arm, data)
    assert data.ncon == 0
    data.qpos[3] = PUBLISHED[name]["low"][3]
    data.qpos[1] = PUBLISHED[name]["high"][1]
    mujoco.mj_forward(arm, data)
    assert data.ncon > 0  # Folded up, it does: its shapes are there to be touched.


def test_payloads_are_rated():
    assert arm_payload(ArmDesign()) == arm_payload(ArmDesign(model="fr3")) == 3.0
    assert arm_payload(ArmDesign(model="mine.xml")) is None


@pytest.mark.parametrize("name", ["panda", "fr3"])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_joint_at_its_speed_limit_can_still_stop_in_its_range(name, side):
    """v^2 / (2 d) of way at the published deceleration, which the Panda's constant limit does not promise."""
    limits = ARMS[name].limits
    low, high = limits.position
    q = np.linspace(low, high, 1001)
    slow, fast = velocity_bounds(limits, q)
    np.testing.assert_allclose(fast, -slow[::-1], rtol=0, atol=1e-12)  # The same in both directions.
    assert (fast <= limits.velocity).all()
    if limits.braking is None:
        assert (fast == limits.velocity).all()
        return
    speed, room = (fast, high - q) if side > 0 else (slow, q - low)
    assert (speed**2 / (2 * limits.braking[1]) <= room + 1e-12).all()
    assert (fast.max(0) == limits.velocity).all()
    end = high - standstill_margin(limits)
    assert (velocity_bounds(limits, end + 1e-9)[1] == 0).all()
    assert (velocity_bounds(limits, end - 1e-4)[1] > 0).all()


def test_the_fr3s_falling_speed_limit_meets_the_rectangle_that_franka_suggests():
    """Franka's suggested pairs of smaller range and constant speed lie on the published curve, to its rounding."""
    high = np.array([2.3476, 1.5454, 2.4937, -0.4226, 2.5100, 4.2841, 2.7045])
    low = np.array([-2.3476, -1.5454, -2.4937, -2.7714, -2.5100, 0.7773, -2.7045])
    speed = np.array([2, 1, 1.5, 1.25, 3, 1.5, 3])
    np.testing.assert_allclose(velocity_bounds(ARMS["fr3"].limits, high)[1], speed, rtol=0.05)
    np.testing.assert_allclose(velocity_bounds(ARMS["fr3"].limits, low)[0], -speed, rtol=0.05)


def test_speeds_without_a_limit_have_no_bounds():
    with pytest.raises(ValueError, match="no speed limit"):
        velocity_bounds(replace(PANDA.limits, velocity=None), np.zeros(7))


@pytest.mark.parametrize("q", [None, (0.5, 0.4, -0.3, -1.5, 0.2, 2.0, 0.1)], ids=["home", "elsewhere"])
def test_gravity_compensation_holds_any_posture(name, arm, q):
    q = ARMS[name].home if q is None else q
    arm.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST  # As in a scene.
    data = mujoco.MjData(arm)
    data.qpos[:] = q
    data.ctrl[:] = q
    mujoco.mj_step(arm, data, 2000)
    np.testing.assert_allclose(data.qpos, q, rtol=0, atol=1e-5)


def test_only_the_flange_carries(name):
    with pytest.raises(DesignError, match=r"arm\.mount_site is 'hand'; allowed: flange"):
        arm_spec(ArmDesign(model=name, mount_site="hand"))


@pytest.mark.parametrize("name", ARMS)
def test_site_and_initial_joints_are_checked_before_the_arm_is_built(name):
    check_arm(ArmDesign(model=name))
    with pytest.raises(DesignError, match=r"arm\.mount_site is 'nope'; allowed: flange"):
        check_arm(ArmDesign(model=name, mount_site="nope"))
    with pytest.raises(DesignError, match=r"arm\.home is 2 numbers; allowed: 7 numbers, one per joint"):
        check_arm(ArmDesign(model=name, home=(1.0, 2.0)))


def test_home_has_a_number_per_joint():
    with pytest.raises(DesignError, match=r"arm\.home is 3 numbers; allowed: 7 numbers"):
        arm_home(ArmDesign(home=(0.0, 1.0, 2.0)), 7)
    np.testing.assert_allclose(arm_home(ArmDesign(), 7), PANDA.home)
    np.testing.assert_allclose(arm_home(ArmDesign(model="mine.xml"), 6), np.zeros(6))
    np.testing.assert_allclose(arm_home(ArmDesign(home=(0.1, 0.2)), 2), [0.1, 0.2])


def _is_within_speed(reach, before, q):
    """Whether a step of 20 ms keeps to the share of the speed that is allowed where it begins."""
    low, high = (0.81 * bound for bound in velocity_bounds(reach.limits, before))
    return ((q - before >= 0.02 * low) & (q - before <= 0.02 * high)).all()


def test_inverse_kinematics_reaches_a_frame_within_the_speed_limit(robot):
    reach = ArmReach(robot)
    q, target = reach.home, reach.T_base(reach.home)
    target[:3, 3] += [0.05, 0.20, 0.10]
    for _ in range(150):
        before, q = q, reach.follow(q, target, 0.02)
        assert _is_within_speed(reach, before, q)
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
    return velocity / max(1.0, (np.abs(velocity) / (SPEED_SHARE * PANDA.limits.velocity)).max()) * dt


@pytest.mark.parametrize("is_near_a_limit", [False, True])
def test_each_step_of_the_arm_solves_the_whole_program(is_near_a_limit):
    """Without the program where no limit binds, and with it where one does: mink's solution either way."""
    reach, rng, bound = ArmReach(PAPER), np.random.default_rng(3), 0
    for _ in range(20):
        q = reach.home + rng.normal(scale=0.1, size=7)
        if is_near_a_limit:
            q[3] = PANDA.limits.position[1][3] - 0.02
        target = reach.T_base(reach.home + rng.normal(scale=0.3, size=7))
        reached = reach.follow(q, target, 0.02)
        np.testing.assert_allclose(reached - q, _by_the_program(reach, q, target, 0.02), rtol=0, atol=1e-9)
        bound += not reach._is_within_limits(q, reach._free_step(q))
    assert (bound > 3) == is_near_a_limit


def test_inverse_kinematics_of_a_place_out_of_reach_stays_within_the_ranges(robot, published):
    reach = ArmReach(robot)
    q, target = reach.home, reach.T_base(reach.home)
    target[:3, 3] += [3.0, 3.0, -3.0]
    for _ in range(300):
        before, q = q, reach.follow(q, target, 0.02)
        assert np.isfinite(q).all()
        assert (q >= published["low"]).all()
        assert (q <= published["high"]).all()
        assert _is_within_speed(reach, before, q)


def test_a_joint_that_has_come_to_its_end_lets_the_others_move_on():
    """The elbow alone changes how far the wrist is from the shoulder; folded up, the FR3's may not move further."""
    reach = ArmReach(replace(PAPER, arm=replace(PAPER.arm, model="fr3")))
    q, folded = reach.home.copy(), reach.home.copy()
    q[3], folded[3] = -2.9, -3.1
    target = reach.T_base(folded)
    for _ in range(400):
        q = reach.follow(q, target, 0.02)
    assert q[3] == pytest.approx(-3.051, abs=1e-3)
    target[1, 3] += 0.1
    for _ in range(150):
        q = reach.follow(q, target, 0.02)
    np.testing.assert_allclose(reach.T_base(q)[:3, 3], target[:3, 3], rtol=0, atol=1e-3)


# A user's own arm: a gantry with a wrist, hanging 1.3 m above its base.
AXES = (("slide", "1 0 0"), ("slide", "0 1 0"), ("slide", "0 0 1"), ("hinge", "0 0 1"), ("hinge", "0 1 0"),
        ("hinge", "1 0 0"))  # fmt: skip


def _mjcf(
    *, site="tool", drive=tuple(range(6)), actuator="position", free=False, extra="", joint=lambda j: "",
    motor=lambda j: "", ranged=range(6),
):  # fmt: skip
    joints, motors = "", ""
    for j, (kind, axis) in enumerate(AXES):
        limits = "-180 180" if kind == "hinge" else "-1 1"
        limits = f'range="{limits}"' if j in ranged else ""
        joints += f'<joint name="j{j}" type="{kind}" axis="{axis}" {limits} armature="1" damping="1" {joint(j)}/>'
    for j in drive:
        gains = 'kp="20000" kv="400"' if actuator == "position" else ""
        motors += f'<{actuator} name="m{j}" joint="j{j}" {gains} {motor(j)}/>'
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


@pytest.mark.parametrize(
    "turn",
    [
        'euler="180 0 0"',
        *(
            pytest.param(turn, marks=pytest.mark.slow)
            for turn in ('zaxis="0 0 -1"', 'axisangle="1 0 0 180"', 'quat="0 1 0 0"')
        ),
    ],
)
def test_the_mount_of_a_users_arm_may_be_turned_in_any_way_that_mjcf_knows(named, turn):
    """The trunk's base axis is the site's z axis, here turned back up."""
    plant = SimPlant(named(_mjcf().replace('pos="0 0 .04"/>', f'pos="0 0 .04" {turn}/>')))
    np.testing.assert_allclose(plant.reset().T_world_base[:3, 0], [0.0, 0.0, 1.0], atol=1e-9)


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
        ("<mujoco><worldbody>", r"^arm\.model 'arm\.xml' is no MJCF; allowed: well-formed XML"),
        (
            "",
            r"^arm\.model is '.*arm\.xml'; allowed: a file that exists, .* of 1 byte to 20 MB; it is empty",
        ),
    ],
    ids=["site", "five", "none", "twice", "motors", "free", "cut", "empty"],
)
def test_arms_that_cannot_carry_are_refused(named, text, match):
    with pytest.raises(DesignError, match=match) as caught:
        SimPlant(named(text))
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_refused(tmp_path):
    allowed = 'allowed: "panda", "fr3" or the path of an MJCF file'
    with pytest.raises(DesignError, match=rf"arm\.model is .*none\.xml.*; {allowed}"):
        arm_spec(ArmDesign(model=str(tmp_path / "none.xml")))
    with pytest.raises(DesignError, match=rf"arm\.model is 'ur5'; {allowed}"):
        arm_spec(ArmDesign(model="ur5"))


RATES = ("velocity", "acceleration", "jerk")


@pytest.mark.parametrize(
    ("changes", "position", "torque", "unjudged"),
    [
        ({}, [1, 1, 1, np.pi, np.pi, np.pi], None, (*RATES, "torque")),
        ({"ranged": ()}, None, None, ("position", *RATES, "torque")),
        ({"ranged": (0, 3)}, [1, np.inf, np.inf, np.pi, np.inf, np.inf], None,
         ("position of 4 of 6 joints", *RATES, "torque")),
        ({"motor": lambda j: f'forcerange="-{90 + j} {90 + j}"', "drive": (5, 3, 1, 0, 2, 4)}, [1] * 3 + [np.pi] * 3,
         [90, 91, 92, 93, 94, 95], RATES),
        ({"motor": lambda j: 'gear="-2" forcerange="-30 30"', "joint": lambda j: f'actuatorfrcrange="-{10 * j + 40} '
          f'{10 * j + 40}"'}, [1] * 3 + [np.pi] * 3, [40, 50, 60, 60, 60, 60], RATES),
        ({"joint": lambda j: 'actuatorfrcrange="-10 20"' if j else 'actuatorfrcrange="-10 10"'}, [1] * 3 + [np.pi] * 3,
         [10] + [np.inf] * 5, (*RATES, "torque of 5 of 6 joints")),
    ],
    ids=["ranges", "nothing", "some ranges", "forces", "gears", "lopsided"],
)  # fmt: skip
def test_a_users_arm_has_the_limits_that_its_file_states(named, changes, position, torque, unjudged):
    """And no others: what is missing is named."""
    limits = arm_limits(named(_mjcf(**changes)).arm)
    if position is None:
        assert limits.position is None
    else:
        np.testing.assert_allclose(limits.position, [np.negative(position), position])
    np.testing.assert_equal(limits.torque, None if torque is None else np.array(torque, float))
    assert limits.velocity is limits.acceleration is limits.jerk is None
    assert find_missing_limits(limits) == unjudged


def test_the_plant_tells_the_limits_of_its_arm(named, robot):
    assert find_missing_limits(SimPlant(named(_mjcf())).arm_limits) == (*RATES, "torque")
    assert SimPlant(robot).arm_limits is ARMS[robot.arm.model].limits


def test_steps_are_those_of_follow() -> None:
    stepped, followed = ArmReach(PAPER), ArmReach(PAPER)
    frame, q = stepped.T_base(stepped.home), followed.home
    frame[:3, 3] += [0.05, 0.02, -0.03]
    steps = list(stepped.steps(stepped.home, frame, 0.1, 20))
    assert len(steps) == 20
    for reached in steps:
        q = followed.follow(q, frame, 0.1)
        np.testing.assert_array_equal(reached, q)
