"""Names that the drivers call exist in the real libraries, where these are installed."""

import pytest

PANDA = {
    "Panda": ("get_robot", "get_state", "raise_error", "start_controller", "stop_controller", "get_joint_limits_lower",
              "get_joint_limits_upper"),
    "controllers.JointPosition": ("set_control",),
    "libfranka.Robot": ("set_collision_behavior", "set_load"),
    "libfranka.RobotState": ("q", "dq", "tau_J", "time", "robot_mode", "m_ee", "current_errors", "last_motion_errors"),
    "libfranka.Duration": ("to_sec",),
    "libfranka.Errors": ("joint_reflex", "cartesian_reflex", "power_limit_violation"),
}  # fmt: skip

FRANKY = {
    "Robot": ("state", "poll_motion", "move", "join_motion", "stop", "is_in_control", "set_collision_behavior",
              "set_load"),
    "RealtimeConfig": ("Ignore",),
    "JointReference": ("q",),
    "JointImpedanceTrackingMotion": ("set_reference",),
    "TorqueStopMotion": (),
    "RobotState": (*PANDA["libfranka.RobotState"], "ddq_est"),
    "Duration": ("to_sec",),
    "Errors": PANDA["libfranka.Errors"],
}  # fmt: skip


@pytest.mark.parametrize(("package", "names"), [("panda_py", PANDA), ("franky", FRANKY)])
def test_the_library_has_what_the_drivers_call(package, names):
    library = pytest.importorskip(package, reason=f"{package} is not installed")
    if package == "panda_py":
        pytest.importorskip("panda_py.controllers")
        pytest.importorskip("panda_py.libfranka")
    for path, attributes in names.items():
        found = library
        for part in path.split("."):
            found = getattr(found, part)
        for attribute in attributes:
            assert hasattr(found, attribute), f"{package}.{path}.{attribute}"


@pytest.mark.parametrize(("package", "modes"), [
    ("panda_py.libfranka", ("kOther", "kIdle", "kMove", "kGuiding", "kReflex", "kUserStopped",
                            "kAutomaticErrorRecovery")),
    ("franky", ("Other", "Idle", "Move", "Guiding", "Reflex", "UserStopped", "AutomaticErrorRecovery")),
])  # fmt: skip
def test_modes_have_the_numbers_that_the_drivers_know(package, modes):
    library = pytest.importorskip(package, reason=f"{package} is not installed")
    assert [int(getattr(library.RobotMode, mode)) for mode in modes] == list(range(7))
