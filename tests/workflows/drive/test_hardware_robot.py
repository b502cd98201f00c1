"""The robot of a robot file, with a twin's motors at the other end of python-can's virtual bus."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk import strategies
from spiraltrunk.control.messages import CameraObservation, Command, Observation
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design import presets
from spiraltrunk.design.drum import size_drum
from spiraltrunk.design.mount import ArmDesign
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.errors import DesignError, DriveError, MissingPackage, RunError
from spiraltrunk.hardware.arm.arm_port import ArmLoad, ArmPort, ArmState
from spiraltrunk.hardware.bus.can_bus import open_can_bus
from spiraltrunk.hardware.log import LogWriter, load_log
from spiraltrunk.hardware.log.channels import StateLog
from spiraltrunk.hardware.motors import load_cell
from spiraltrunk.hardware.motors.sts.servos import StsServos
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.reaction import LET_GO_TIME, RAMP_TIME
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.setup.load_cell_setup import LoadCellSetup
from spiraltrunk.hardware.setup.robot_file import CableSetup, MotorSetup, RobotFile
from spiraltrunk.hardware.setup.robot_limits import check_arm_model
from spiraltrunk.hardware.twin.board import BoardTwin
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.load_cells import LoadCellTwin
from spiraltrunk.hardware.twin.motor import MotorParameters, MotorTwin
from spiraltrunk.hardware.twin.motors import MotorTwins
from spiraltrunk.hardware.twin.sts_bus import MemoryStream, StsTwin
from spiraltrunk.hardware.twin.sts_servo import ServoTwin
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.robot.arm import arm_home, arm_limits
from spiraltrunk.workflows.drive import hardware_robot
from spiraltrunk.workflows.drive.camera import Camera
from spiraltrunk.workflows.drive.hardware_robot import HardwareRobot
from spiraltrunk.workflows.drive.hardware_trial import build_announced_task, run_on_hardware, summarise_hardware_trial
from spiraltrunk.workflows.drive.trial import run_on_twin
from spiraltrunk.workflows.drive.twin.machine_arm import MachineArm
from spiraltrunk.workflows.drive.twin.machine_load import MachineLoad
from spiraltrunk.workflows.grasp.choice.ground import set_ground
from spiraltrunk.workflows.grasp.world import draw_scene

DESIGN = presets.PAPER
OBJECT = parse_object("cylinder-60")
FILE = RobotFile(name="bench", bus="virtual:robot", motors=MotorSetup(family="gm6020", ids=(5, 2, 3)), watchdog="board")


@contextmanager
def connect(
    file: RobotFile = FILE, machine: SimMachine | None = None, arm: ArmPort | None = None, **options: bool
) -> Iterator[HardwareRobot]:
    """A robot whose motors are twins, each process of the bus in lock-step."""
    clock = TwinClock()
    far = open_can_bus(file.bus, clock)
    load = SpringTrunk(DESIGN) if machine is None else MachineLoad(machine)
    radius = size_drum(DESIGN).winding_radius
    motors = [MotorTwin(MotorParameters(drum_radius=radius, wound=-0.004)) for _ in file.motors.ids]
    board = BoardTwin() if file.watchdog == "board" else None
    if machine is not None:
        arm = MachineArm(machine, clock)
        clock.attach(arm)
    clock.attach(MotorTwins(far, load, motors, motor_ids=list(file.motors.ids), board=board))
    try:
        with HardwareRobot(DESIGN, file, clock=clock, arm=arm, **options) as robot:
            yield robot
    finally:
        far.close()


@pytest.mark.slow
def test_it_homes_and_moves_its_cables():
    with connect() as robot:
        robot.prepare()
        robot.pull_to([0.03, -0.01, -0.01], tension=20.0, hold=0.5)
        cables = robot.driver.snapshot().cables
    assert cables[0].pull > 0.02
    assert max(cable.pull for cable in cables[1:]) < -0.005
    assert (robot.driver.mode, robot.driver.faults) == (Mode.SAFE, ())


@pytest.mark.parametrize("error", [None, KeyboardInterrupt])
def test_cables_are_let_go_slowly_at_the_end_and_fast_on_an_error(error):
    """The ramps of `safety.reaction`, with the one message at their end."""
    with suppress(KeyboardInterrupt), connect() as robot:
        robot.prepare()
        robot.pull_to([0.005, 0.0, 0.0], tension=20.0, hold=0.0)
        began = robot.clock.now()
        if error is not None:
            raise error
    took, kinds = robot.clock.now() - began, [fault.kind for fault in robot.driver.faults]
    if error is None:
        assert (robot.driver.mode, kinds) == (Mode.SAFE, [])
        assert LET_GO_TIME - 1e-6 < took < LET_GO_TIME + 0.05
    else:
        assert kinds == [FaultKind.STOPPED]
        assert RAMP_TIME - 1e-6 < took < RAMP_TIME + 0.01


@pytest.mark.slow
def test_a_fault_while_it_lets_go_is_told():
    with connect() as robot:
        robot.prepare()
        robot.watch = lambda driver: driver.mode is Mode.ARMED and driver.stop()
        with pytest.raises(RunError, match="a person stopped the robot"):
            robot.finish()


def test_limits_of_the_file_hold():
    strong, weak = replace(FILE, cables=CableSetup(tension_max=8.0)), []
    with connect(strong) as robot:
        robot.prepare()
        robot.watch = lambda driver: weak.append(max(cable.tension for cable in driver.snapshot().cables))
        robot.pull_to([0.06, -0.02, -0.02], tension=30.0, hold=0.5)
    assert 4.0 < max(weak) < 8.0 * 1.15


@pytest.mark.slow
def test_slack_is_wound_in_besides():
    slack = (0.008, 0.0, 0.0)
    with connect(replace(FILE, cables=CableSetup(slack=slack))) as robot:
        robot.prepare()
        robot.pull_to([0.03, -0.01, -0.01], tension=30.0, hold=1.0)
        wound, seen = robot.driver.snapshot().cables[0].pull, robot.read_pulls()[0]
    assert wound - seen == pytest.approx(slack[0] * wound / (DESIGN.cable_stroke + slack[0]))


def test_without_a_watchdog_it_is_not_armed_unless_that_is_said():
    file = replace(FILE, watchdog="none")
    with connect(file) as robot, pytest.raises(DriveError, match="no watchdog"):
        robot.prepare()
    with connect(file, without_watchdog=True) as robot:
        robot.prepare()
        assert robot.driver.mode.value == "armed"


def test_nothing_is_opened_for_a_file_that_does_not_fit(monkeypatch):
    monkeypatch.setattr(hardware_robot, "open_can_bus", lambda *_, **__: pytest.fail("a bus was opened"))
    with pytest.raises(DesignError, match=r"motors\.ids is 2 ids; allowed: 3"):
        HardwareRobot(DESIGN, replace(FILE, motors=MotorSetup(family="gm6020", ids=(1, 2))))


CELLS = LoadCellSetup(port="/dev/absent", cables=(1, 2, 3), offsets=(0.0, 0.3, 0.0), scales=(1.0, 1.0, -1.0))


def test_load_cells_of_the_file_are_opened_used_and_closed(monkeypatch):
    """A board whose cells tell 1.5 N at every cable, which the motors' friction may hide."""
    board, asked = LoadCellTwin(CELLS.build_settings(3), lambda: [1.5] * 3), []

    def open_board(port, baud):
        asked.append((port, baud))
        return board

    monkeypatch.setattr(load_cell, "open_serial", open_board)
    with connect(replace(FILE, load_cells=CELLS)) as robot:
        robot.clock.attach(board)
        robot.listen()
        cables = robot.driver.snapshot().cables
        assert [cable.felt for cable in cables] == pytest.approx([1.5] * 3, abs=0.15)
        assert not board.is_closed
    assert asked == [("/dev/absent", 115_200)]
    assert board.is_closed


def test_load_cells_that_are_absent_are_one_line_and_no_bus_is_opened(monkeypatch):
    monkeypatch.setattr(hardware_robot, "open_can_bus", lambda *_, **__: pytest.fail("a bus was opened"))
    with pytest.raises(DriveError, match="serial port '/dev/absent' cannot be opened") as caught:
        HardwareRobot(DESIGN, replace(FILE, load_cells=CELLS))
    assert "\n" not in str(caught.value)


def test_no_bus_is_opened_where_the_arm_cannot_be(monkeypatch):
    monkeypatch.setattr(hardware_robot, "open_can_bus", lambda *_, **__: pytest.fail("a bus was opened"))
    with pytest.raises((MissingPackage, DriveError)):
        HardwareRobot(DESIGN, replace(FILE, arm="panda:127.0.0.1"))


def test_the_bus_is_closed_where_the_driver_cannot_be_built(monkeypatch):
    opened = []

    def remember(*arguments, **named):
        opened.append(open_can_bus(*arguments, **named))
        return opened[0]

    monkeypatch.setattr(hardware_robot, "open_can_bus", remember)
    monkeypatch.setattr(hardware_robot, "TrunkDriver", lambda **_: (_ for _ in ()).throw(DriveError("no driver")))
    with pytest.raises(DriveError, match="no driver"):
        HardwareRobot(DESIGN, FILE)
    with pytest.raises(DriveError, match="closed"):
        opened[0].receive()


class Relay:
    """Port of a relay that notes its pulses."""

    cts = True

    def __init__(self) -> None:
        self.pulses, self.is_closed = [], False

    def write(self, data: bytes) -> None:
        self.pulses.append(time.monotonic())

    def close(self) -> None:
        self.is_closed = True


def test_a_relay_is_fed_from_power_up_until_the_loop_does_so(monkeypatch):
    """Opening the bus takes half a second, as of servos that are asked one by one."""
    relay, times = Relay(), []

    def open_slowly(*arguments, **named):
        times.append(time.monotonic())
        time.sleep(0.5)
        return open_can_bus(*arguments, **named)

    monkeypatch.setattr(hardware_robot, "BOOT_TIME", 0.2)
    monkeypatch.setattr(hardware_robot, "open_relay", lambda port: relay)
    monkeypatch.setattr(hardware_robot, "open_can_bus", open_slowly)
    with HardwareRobot(DESIGN, replace(FILE, watchdog="relay:/dev/absent"), arm=LoadedArm()) as robot:
        assert relay.pulses[0] == pytest.approx(times[0] - 0.2, abs=0.1)
        robot.run(0.3)
    assert relay.pulses[-1] > times[0] + 0.8
    assert np.diff(relay.pulses).max() < 0.2, "a computer under load is late, by less than the bus takes"
    assert relay.is_closed


def test_a_relay_that_is_gone_opens_no_robot(monkeypatch):
    relay = Relay()
    relay.write = lambda data: (_ for _ in ()).throw(OSError("unplugged"))
    monkeypatch.setattr(hardware_robot, "BOOT_TIME", 0.01)
    monkeypatch.setattr(hardware_robot, "open_relay", lambda port: relay)
    with pytest.raises(DriveError, match="the relay's serial line is gone"):
        HardwareRobot(DESIGN, replace(FILE, watchdog="relay:/dev/absent"))
    assert relay.is_closed


class LoadedArm(ArmPort):
    """An arm at rest that notes which thread sets its load, and who asks it at the same time."""

    limits = arm_limits(DESIGN.arm)

    def __init__(self) -> None:
        self.calls, self.n_inside, self.n_most = [], 0, 0

    def _enter(self, call: str) -> None:
        self.n_inside += 1
        self.n_most = max(self.n_most, self.n_inside)
        time.sleep(0.005)
        self.n_inside -= 1
        self.calls.append(call)

    def read(self) -> ArmState:
        self._enter("read")
        zeros = np.zeros(7)
        return ArmState(time=time.monotonic(), position=zeros, velocity=zeros, acceleration=zeros, torque=zeros)

    def set_load(self, load: ArmLoad) -> None:
        self._enter("load")

    def send(self, position: np.ndarray) -> None: ...

    def hold(self) -> None: ...

    def close(self) -> None: ...


def test_the_arm_is_told_its_load_before_the_loop_asks_it():
    arm = LoadedArm()
    with HardwareRobot(DESIGN, FILE, arm=arm) as robot, pytest.raises(DriveError, match="no feedback"):
        robot.prepare()
    assert arm.calls[0] == "load"
    assert arm.calls.count("load") == 1
    assert "read" in arm.calls
    assert arm.n_most == 1, "two threads asked the arm at once"


def test_an_absent_relay_is_one_line_and_no_bus_is_opened(monkeypatch):
    monkeypatch.setattr(hardware_robot, "open_can_bus", lambda *_, **__: pytest.fail("a bus was opened"))
    with pytest.raises(DriveError, match=r"relay '/dev/absent' cannot be opened: .*; ports found: ") as caught:
        HardwareRobot(DESIGN, replace(FILE, watchdog="relay:/dev/absent"))
    assert "\n" not in str(caught.value)


def test_a_supply_that_falls_is_a_fault_of_servos(monkeypatch: pytest.MonkeyPatch) -> None:
    twin = StsTwin(SpringTrunk(DESIGN), [ServoTwin(i) for i in (1, 2, 3)])
    clock, start, measure = TwinClock(twin), StsServos.from_settings, ServoTwin._measure
    monkeypatch.setattr(
        StsServos, "from_settings", lambda settings, clock: start(settings, clock, stream=MemoryStream(twin))
    )
    file = RobotFile(name="x", bus="sts:/dev/absent", motors=MotorSetup(family="sts", ids=(1, 2, 3)))
    with HardwareRobot(DESIGN, file, without_watchdog=True, clock=clock) as robot:
        robot.run(0.1)
        robot.driver.home()
        monkeypatch.setattr(ServoTwin, "_measure", lambda servo: measure(servo)._replace(voltage=9.0))
        robot.run(0.2)
        assert robot.driver.faults[0].kind is FaultKind.VOLTAGE
        assert robot.driver.faults[0].text == "the supply has 9.0 V; allowed: 9.6 to 14.4 V"


@pytest.mark.parametrize("bus", ["board:/dev/absent", "sts:/dev/absent"])
def test_an_absent_port_is_one_line(bus):
    family = bus.partition(":")[0].replace("board", "gm6020")
    with pytest.raises(DriveError, match="/dev/absent") as caught:
        HardwareRobot(DESIGN, RobotFile(name="x", bus=bus, motors=MotorSetup(family=family, ids=(1, 2, 3))))
    assert "\n" not in str(caught.value)


class Curl(Strategy[int]):
    """Curls the trunk for half a second, where the arm is."""

    name, number = "curl", 0

    def init(self, observation: Observation) -> int:
        self.T = observation.T_world_base
        return 0

    def step(self, state: int, observation: Observation) -> tuple[int, Command]:
        return state + 1, Command(
            T_world_base=self.T, cable_tension=np.array([15.0, 1.0, 1.0]), cable_pull=np.array([0.03, np.inf, np.inf])
        )

    def status(self, state: int) -> Status:
        return Status(phase="prehension", action="curl", is_done=state > 25)


@pytest.mark.parametrize(
    ("arm", "model"),
    [("franky:10.0.0.1", "panda"), ("panda:10.0.0.1", "fr3"), ("panda:10.0.0.1", "own.xml"), ("franky:h", "own.xml")],
)
def test_an_arm_with_the_limits_of_another_is_refused_before_anything_is_opened(arm, model, monkeypatch):
    for name in ("open_can_bus", "open_relay", "ArmSettings"):
        monkeypatch.setattr(hardware_robot, name, lambda *_, **__: pytest.fail("a port was opened"))
    design = replace(DESIGN, arm=ArmDesign(model=model))
    with pytest.raises(DesignError) as caught:
        HardwareRobot(design, replace(FILE, arm=arm))
    fitting = {"panda": "panda:HOST or none", "fr3": "franky:HOST or none"}.get(model, "none")
    assert str(caught.value) == (
        f"arm is '{arm}'; allowed: {fitting}, as the design's arm.model is '{model}' (panda drives a \"panda\", franky "
        'drives a "fr3"): correct the one that does not name the arm that is connected'
    )


@pytest.mark.parametrize(("arm", "model"), [("panda:h", "panda"), ("franky:h", "fr3"), ("none", "own.xml")])
def test_the_arm_of_the_design_is_taken(arm, model):
    check_arm_model(replace(FILE, arm=arm), replace(DESIGN, arm=ArmDesign(model=model)))


@pytest.fixture
def machine() -> SimMachine:
    """MuJoCo's arm and trunk, in place of the real ones."""
    machine = SimMachine(DESIGN, replace(draw_scene(OBJECT, 0), timestep=1e-3))
    machine.restore()
    return machine


@pytest.mark.slow
def test_a_strategy_runs_and_is_not_judged(machine, tmp_path):
    path, strategy = tmp_path / "drive.mcap", Curl()
    with connect(machine=machine) as robot:
        trial = run_on_hardware(robot, OBJECT, strategy, log=path)
    result = summarise_hardware_trial(trial, strategy, "cylinder-60")
    assert (result["verdict"], result["success"], result["gave_up"]) == ("not judged", None, None)
    assert result["duration_s"] == pytest.approx(0.5)
    assert trial.log.observations[-1].cable_pull[0] > 0.005
    log = load_log(path)
    assert (log.metadata.bus, log.metadata.is_twin, log.is_complete) == (FILE.bus, False, True)


class GivesUpInMotion(Curl):
    """Winds in from step to step, and gives up on the way."""

    def step(self, state: int, observation: Observation) -> tuple[int, Command]:
        state, command = super().step(state, observation)
        return state, replace(command, cable_pull=np.array([5e-4 * state, np.inf, np.inf]))

    def status(self, state: int) -> Status:
        return replace(super().status(state), gave_up="nothing was held" if state > 25 else None)


class StandingArm(LoadedArm):
    """An arm that stands in its home posture."""

    home = np.array(arm_home(DESIGN.arm, 7))

    def read(self) -> ArmState:
        zeros = np.zeros(7)
        return ArmState(time=math.inf, position=self.home, velocity=zeros, acceleration=zeros, torque=zeros)


def test_the_result_is_of_the_end_of_the_run_and_not_of_the_time_that_files_take(tmp_path, monkeypatch):
    """A log of minutes is closed within seconds, in which the loop goes on in its thread: here, in simulated time."""
    close, path = LogWriter.close, tmp_path / "drive.mcap"

    with connect(arm=StandingArm()) as robot:

        def close_slowly(log: LogWriter) -> None:
            close(log)
            robot.run(1.0)

        monkeypatch.setattr(LogWriter, "close", close_slowly)
        trial = run_on_hardware(robot, OBJECT, GivesUpInMotion(), log=path)
        assert trial.log.gave_up == "nothing was held"
        assert (trial.snapshot.mode, trial.snapshot.faults) == (Mode.ARMED, ())
        assert (robot.driver.mode, robot.driver.faults) == (Mode.SAFE, ())
    assert load_log(path)[StateLog].mode == ("armed", "safe")


def test_the_task_is_the_announced_one():
    strategy = strategies.get("wrap-vertical")
    task = build_announced_task(DESIGN, OBJECT, strategy)
    assert task.target.position == pytest.approx(draw_scene(OBJECT, 7, strategy=strategy).position)


def test_a_thick_hung_object_hangs_clear_of_the_trunk_as_in_trials(monkeypatch):
    class Stop(Exception):
        pass

    def stop(design, scene, options):
        raise Stop(scene)

    thick, strategy = design_from_rules(arm_radius=0.065), strategies.get("wrap-vertical")
    shape = parse_object("cylinder-120")
    scene = draw_scene(shape, 7, strategy=strategy)
    usual, clear = scene.position, set_ground(thick, scene, strategy).position
    assert clear[1] > usual[1] + 0.005
    assert build_announced_task(thick, shape, strategy).target.position == pytest.approx(clear)
    monkeypatch.setattr("spiraltrunk.workflows.drive.trial.TwinRobot", stop)
    with pytest.raises(Stop) as caught:
        run_on_twin(thick, shape, strategy=strategy, seed=7)
    assert caught.value.args[0].position == pytest.approx(clear)


def test_a_strategy_that_needs_a_camera_is_refused_without_one(machine):
    with connect(machine=machine) as robot, pytest.raises(RunError, match="kick needs a camera"):
        run_on_hardware(robot, OBJECT, strategies.get("kick"))


def test_a_strategy_that_needs_the_gripper_is_refused_without_one(machine):
    with connect(machine=machine) as robot, pytest.raises(RunError, match="pinch needs the gripper"):
        run_on_hardware(robot, OBJECT, strategies.get("pinch"), camera=lambda: None)
    assert not robot.driver.is_homed


@pytest.mark.slow
def test_a_camera_of_the_user_is_asked_with_the_time_of_the_run(machine):
    times = []

    def look(time):
        times.append(time)
        return CameraObservation(time=time - 0.03, position=np.ones(3), axis=np.array([0.0, 0.0, 1.0]))

    class Watching(Curl):
        needs_camera = True

    with connect(machine=machine) as robot:
        trial = run_on_hardware(robot, OBJECT, Watching(), camera=Camera(look, "bench:look", robot.clock))
    assert times == pytest.approx([seen.time for seen in trial.log.observations], abs=0.005)
    assert [seen.camera.time for seen in trial.log.observations] == pytest.approx([t - 0.03 for t in times])


@pytest.mark.slow
def test_a_camera_that_fails_ends_the_run(machine):
    def look(time):
        return None if time < 0.2 else "a cup"

    with connect(machine=machine) as robot, pytest.raises(RunError, match="camera bench:look returned 'a cup'; allow"):
        run_on_hardware(robot, OBJECT, Curl(), camera=Camera(look, "bench:look", robot.clock))
    assert robot.driver.mode is not Mode.ARMED


def test_without_an_arm_no_strategy_runs():
    with connect() as robot, pytest.raises(RunError, match="names no arm"):
        run_on_hardware(robot, OBJECT, Curl())
