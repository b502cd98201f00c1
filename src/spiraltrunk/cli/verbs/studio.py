"""``spiraltrunk studio``: the browser page."""

from __future__ import annotations

import argparse
import json
import threading
import webbrowser
from typing import Any

from spiraltrunk.cli.arguments import add_parser, read_count, read_text
from spiraltrunk.cli.output import DONE, Answer, complain


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
    parser.add_argument("--no-browser", action="store_true", help="print the address, and open no browser")


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design
    from spiraltrunk.studio.studio import Studio, StudioOptions
    from spiraltrunk.studio.tabs import TABS

    design = load_design(arguments.design)
    studio = Studio(design, TABS, StudioOptions(host=arguments.host, port=arguments.port))
    try:
        if studio.needs_token:
            complain(f"others can reach this studio at {arguments.host}: whoever has the address can use it", DONE)
        line = json.dumps({"address": studio.address})  # One line: a program reads it while the studio runs.
        print(line if arguments.json else f"studio: {studio.address} (Ctrl-C ends it)", flush=True)
        if not arguments.no_browser:
            webbrowser.open(studio.address)
        threading.Event().wait()
    finally:
        studio.stop()
    return DONE, ""
