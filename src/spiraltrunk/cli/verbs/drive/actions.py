"""Status, homing and moves of the cables."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import Parser, read_count, read_number, read_seed, read_text
from spiraltrunk.cli.output import DONE, Answer, UsageError, complain, format_count, format_json
from spiraltrunk.cli.verbs.drive.figures import format_figure
from spiraltrunk.cli.verbs.drive.move_check import (
    HOLD,
    MoveSettings,
    check_jog,
    check_lengths,
    check_slack,
    list_distances,
    read_move,
    warn_short,
    warn_short_steps,
)
from spiraltrunk.cli.verbs.drive.pose_file import add_poses_file, check_save, save_pose
from spiraltrunk.cli.verbs.drive.robot import compute_state, open_robot
from spiraltrunk.workflows.drive.move_defaults import SPEED, TENSION

if TYPE_CHECKING:
    from spiraltrunk.hardware.driver.snapshot import Snapshot
    from spiraltrunk.workflows.drive.robot import Robot


def add_action(actions: Any, name: str, run: Callable[[argparse.Namespace], Answer], what: str) -> Parser:
    """The parser of a new action."""
    parser: Parser = actions.add_parser(name, help=what, description=what, allow_abbrev=False)
    parser.add_argument(
        "--json", action="store_true", default=argparse.SUPPRESS, help="print one JSON object, nothing else"
    )
    parser.add_argument("--bus", type=read_text, default=argparse.SUPPRESS, metavar="BUS", help="as before the action")
    parser.add_argument("--seed", type=read_seed, default=argparse.SUPPRESS, help="as before the action")
    parser.set_defaults(run=run)
    return parser


def add_status(actions: Any, name: str) -> None:
    """Add the action that listens to the motors; nothing is sent to them but a watchdog's heartbeat."""
    add_action(actions, name, _status, "listen to the motors, and tell their state")


def add_home(actions: Any, name: str) -> None:
    """Add the action that homes the drums."""
    add_action(actions, name, _home, "wind all cables in gently until the trunk is straight between them")


def add_pull(actions: Any, name: str) -> None:
    """Add the action that winds every cable to a length."""
    parser = add_action(actions, name, _pull, "home, and wind every cable to a length since the straight trunk")
    parser.add_argument(
        "pulls_mm",
        type=read_number,
        nargs="+",
        metavar="MM",
        help="cable to wind in, one for each, negative to let out",
    )
    add_move(parser)


def add_jog(actions: Any, name: str) -> None:
    """Add the action that moves one cable."""
    parser = add_action(actions, name, _jog, "home, and wind one cable in or out: which one moves shows the wiring")
    parser.add_argument("cable", type=read_count, nargs="?", metavar="CABLE", help="cable, counted from 1")
    parser.add_argument("way_mm", type=read_number, nargs="?", metavar="MM", help="length to wind in; < 0 to let out")
    parser.add_argument(
        "--gamepad", type=read_count, nargs="?", const=0, metavar="N",
        help="move all cables with this gamepad (default 0) instead, until its stop button",
    )  # fmt: skip
    parser.add_argument("--save", type=read_text, metavar="NAME", help="save where the cables are at the end as a pose")
    add_poses_file(parser)
    add_move(parser)


def add_protocol(actions: Any, name: str) -> None:
    """Add the action that carries out the pulls of a motion-capture run."""
    parser = add_action(
        actions, name, _protocol, "home, and carry out a run of a motion-capture protocol, step by step"
    )
    parser.add_argument("protocol", type=read_text, metavar="PROTOCOL", help="paper, or a protocol.toml")
    parser.add_argument("run_name", type=read_text, metavar="RUN", help="name of the run, such as bend-dorsal")
    add_move(parser)


def add_move(parser: Parser) -> None:
    """Add how cables are moved."""
    parser.add_argument(
        "--tension-n", type=read_number, metavar="N",
        help=f"largest tension of each cable (default {TENSION:g}, or the limit of --robot where that is lower)",
    )  # fmt: skip
    parser.add_argument(
        "--speed-mm-s", type=read_number, metavar="V",
        help=f"speed (default {1e3 * SPEED:g}, or the limit of --robot where that is lower)",
    )  # fmt: skip
    parser.add_argument(
        "--hold-s", type=read_number, metavar="S", help=f"time for which the end is held (default {HOLD:g})"
    )


def _status(arguments: argparse.Namespace) -> Answer:
    with open_robot(arguments) as robot:
        robot.listen()
        return answer(arguments, robot.driver.snapshot())


def _home(arguments: argparse.Namespace) -> Answer:
    with open_robot(arguments) as robot:
        robot.home()
        return answer(arguments, robot.driver.snapshot())


def _pull(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design

    design = load_design(arguments.design)
    settings = read_move(arguments, design)
    check_lengths(design, arguments.pulls_mm)
    with open_robot(arguments) as robot:
        robot.prepare()
        pulls = [1e-3 * pull for pull in arguments.pulls_mm]
        move(robot, pulls, settings)
        end = robot.finish()
        warn_short(robot.compute_pulls(end), pulls)
        return answer(arguments, end)


def _jog(arguments: argparse.Namespace) -> Answer:
    _check_jog_given(arguments)
    from spiraltrunk.design import load_design

    design = load_design(arguments.design)
    settings = read_move(arguments, design)
    if arguments.save is not None:
        check_save(arguments, design, arguments.save)
    if arguments.gamepad is not None:
        return _jog_with_gamepad(arguments, settings)
    check_jog(design, arguments.cable, arguments.way_mm)
    with open_robot(arguments) as robot:
        robot.prepare()
        pulls = robot.read_pulls()
        pulls[arguments.cable - 1] += 1e-3 * arguments.way_mm
        move(robot, pulls, settings)
        end = robot.finish()
        warn_short(robot.compute_pulls(end), pulls)
        _save(arguments, robot, end)
        return answer(arguments, end)


def _check_jog_given(arguments: argparse.Namespace) -> None:
    """Refuse anything but a cable with its length, or a gamepad."""
    given = [name for name in ("cable", "way_mm", "gamepad") if getattr(arguments, name) is not None]
    if given == ["gamepad"] and arguments.hold_s is not None:
        raise UsageError("--hold-s and --gamepad given; allowed: --hold-s with a cable and a length")
    if given in (["cable", "way_mm"], ["gamepad"]):
        return
    names = {"cable": "a cable", "way_mm": "a length", "gamepad": "--gamepad"}
    told = " and ".join(names[name] for name in given) if given else "neither a cable nor --gamepad"
    missing = " without a length" if given == ["cable"] else ""
    raise UsageError(f"{told} given{missing}; allowed: a cable and a length to wind in, or --gamepad alone")


def _jog_with_gamepad(arguments: argparse.Namespace, settings: MoveSettings) -> Answer:
    from spiraltrunk.hardware.gamepad import Gamepad
    from spiraltrunk.workflows.drive.gamepad_jog import jog_with_gamepad

    with Gamepad(arguments.gamepad) as gamepad, open_robot(arguments, is_real_time=True) as robot:
        robot.prepare()
        why = jog_with_gamepad(robot, gamepad, tension=settings.tension, speed=settings.speed)
        end = robot.driver.snapshot()
        robot.driver.stop()  # As a stop button does, also where the gamepad is gone.
        complain(why, DONE)
        _save(arguments, robot, end)
        return answer(arguments, end)


def _save(arguments: argparse.Namespace, robot: Robot, end: Snapshot) -> None:
    """Save where the cables were at the end, where that is asked for."""
    if arguments.save is not None:
        save_pose(arguments, robot.design, robot.compute_pulls(end), arguments.save)


def _protocol(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design
    from spiraltrunk.mocap.protocol.schedule import build_schedule
    from spiraltrunk.mocap.protocol.toml import load_protocol

    protocol, design = load_protocol(arguments.protocol), load_design(arguments.design)
    settings = read_move(arguments, design)
    check_slack(arguments, design, protocol)
    schedule = build_schedule(design, protocol, protocol.run(arguments.run_name))
    steps = []
    with open_robot(arguments) as robot:
        robot.prepare()
        for pull in schedule.pull.tolist():
            move(robot, pull, settings)
            cables = robot.driver.snapshot().cables
            steps.append(
                {
                    "pull_mm": [1e3 * one + 0.0 for one in robot.read_pulls()],
                    "target_mm": [1e3 * one for one in pull],
                    "tension_n": [cable.tension for cable in cables],
                }
            )
        end = robot.finish()
        warn_short_steps(steps)
        return answer(arguments, end, steps)


def move(robot: Robot, pulls: list[float], settings: MoveSettings) -> None:
    """Wind the cables to these pulls [m]."""
    robot.pull_to(pulls, tension=settings.tension, speed=settings.speed, hold=settings.hold)


def answer(arguments: argparse.Namespace, snapshot: Snapshot, steps: list[dict[str, Any]] | None = None) -> Answer:
    """A state of the robot as an answer."""
    state = compute_state(snapshot) | {"bus": arguments.bus} | ({} if steps is None else {"steps": steps})
    if arguments.json:
        return DONE, format_json(state)
    from spiraltrunk.report import format_table

    rows: list[tuple[str, ...]] = [
        (str(number), format_figure(cable["pull_mm"], 1), format_figure(cable["tension_n"], 1), _format_warmth(cable))
        for number, cable in enumerate(state["cables"], start=1)
    ]
    header: tuple[str, ...] = ("cable", "pull [mm]", "tension [N]", "motor [degC]")
    if any(cable["load_cell_age_ms"] is not None for cable in state["cables"]):
        header += ("load cell [N]",)
        rows = [(*row, _format_cell(cable)) for row, cable in zip(rows, state["cables"], strict=True)]
    title = f"{state['bus']}: {state['mode']}, {'homed' if state['is_homed'] else 'not homed'}\n"
    if steps is not None:
        distances = [one for cable in range(len(rows)) for _, one in list_distances(steps, cable)]
        told = f", pulls within {max(distances):.2f} mm of their targets" if distances else ", all cables free"
        title = f"{format_count(len(steps), 'step')}{told}\n{title}"
    return DONE, "\n".join([format_table(rows, header=header, title=title, indent=2), *_list_notes(state)])


def _list_notes(state: dict[str, Any]) -> list[str]:
    """Motors without feedback, and how late the loop woke by the computer's clock."""
    silent = [str(i) for i, cable in enumerate(state["cables"], start=1) if math.isnan(cable["temperature_degc"])]
    late = [state["lateness_ms"][part] for part in ("p50", "p99", "p999")]
    notes = [f"no feedback of motor {', '.join(silent)}: no supply, another id, or another bus"] if silent else []
    if state["watchdog_absence"]:
        notes.append(f"no watchdog is present: {state['watchdog_absence']}")
    if any(late):
        notes.append(f"loop late {'/'.join(f'{part:.1f}' for part in late)} ms (p50/p99/p99.9)")
    return ["", *notes] if notes else []


def _format_warmth(cable: dict[str, Any]) -> str:
    """Temperature of a cable's motor."""
    return format_figure(cable["temperature_degc"], 0)


def _format_cell(cable: dict[str, Any]) -> str:
    """Reading of a cable's load cell."""
    if cable["load_cell_age_ms"] is None:
        return "-"
    return "none" if cable["load_cell_n"] is None else format_figure(cable["load_cell_n"], 2)
