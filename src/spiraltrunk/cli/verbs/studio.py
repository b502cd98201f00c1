"""``spiraltrunk studio``: the browser page."""

from __future__ import annotations

import argparse
import json
import threading
import warnings
import webbrowser
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_count, read_text
from spiraltrunk.cli.output import DONE, Answer, complain

if TYPE_CHECKING:
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.hardware.setup.robot_file import RobotFile
    from spiraltrunk.studio.page.page import Page
    from spiraltrunk.studio.page.tab import Tab
    from spiraltrunk.studio.robot.hub import RobotHub


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "studio", _run, "open a browser page over design, shape, grasp, measurement and robot")
    parser.add_argument(
        "design", nargs="?", default="paper", type=read_text, metavar="DESIGN", help="preset or TOML file"
    )
    parser.add_argument(
        "--host", default="127.0.0.1", type=read_text, metavar="ADDRESS",
        help="address to listen on; with any but this computer's own, pages need the token in the printed address",
    )  # fmt: skip
    parser.add_argument("--port", default=8080, type=read_count, metavar="N", help="port; 0 takes a free one")
    parser.add_argument(
        "--robot", type=read_text, metavar="FILE",
        help="how a robot is wired: a TOML file; the tab Robot then offers it beside its twin, opening no port before",
    )  # fmt: skip
    parser.add_argument(
        "--without-watchdog", action="store_true", help="arm although nothing ends the torque when this computer dies"
    )
    parser.add_argument("--no-browser", action="store_true", help="print the address, and open no browser")


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design
    from spiraltrunk.studio.page.scratch import remove_scratch
    from spiraltrunk.studio.server.heap import bound_heap
    from spiraltrunk.studio.studio import Studio, StudioOptions

    bound_heap()
    warnings.filterwarnings("ignore", message=r"Queued a \w+ on a closed connection")  # By a page that closes.
    design = load_design(arguments.design)
    file, opening = _load_robot(arguments.robot, design), threading.Lock()
    hubs: list[RobotHub] = []

    def open_hub() -> RobotHub:
        from spiraltrunk.studio.robot.hub import RobotHub

        with opening:
            if not hubs:
                hubs.append(RobotHub(design, file, without_watchdog=arguments.without_watchdog))
        return hubs[0]

    def load_tabs() -> Sequence[Callable[[Page], Tab]]:
        from spiraltrunk.studio.tabs import build_tabs

        return build_tabs(open_hub)

    def close_hubs() -> None:
        for hub in hubs:
            hub.close()

    with ExitStack() as ends:  # The last is ended first, and each whatever becomes of the others.
        ends.callback(remove_scratch)  # Exit handlers, which would do it, do not run after Ctrl-C.
        ends.callback(close_hubs)  # Once more, for a robot that a page connected meanwhile.
        studio = Studio(design, load_tabs, StudioOptions(host=arguments.host, port=arguments.port))
        ends.callback(studio.stop)
        ends.callback(close_hubs)
        if studio.needs_token:
            complain(f"others can reach this studio at {arguments.host}: whoever has the address can use it", DONE)
        line = json.dumps({"address": studio.address})  # One line: a program reads it while the studio runs.
        try:
            print(line if arguments.json else f"studio: {studio.address} (Ctrl-C ends it)", flush=True)
        except BrokenPipeError:  # Nobody reads the address.
            return DONE, ""
        if not arguments.no_browser:
            webbrowser.open(studio.address)
        threading.Event().wait()
    return DONE, ""


def _load_robot(path: str | None, design: TrunkDesign) -> RobotFile | None:
    if path is None:
        return None
    from spiraltrunk.hardware.setup.robot_limits import load_fitting_file

    return load_fitting_file(path, design)
