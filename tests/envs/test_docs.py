"""The guide tells every number of observations, every control mode and every argument."""

import inspect
import re
from pathlib import Path

from spiraltrunk.control.encoding import ControlMode, agent_names, environment_names
from spiraltrunk.design import presets
from spiraltrunk.envs import TrunkEnv
from spiraltrunk.envs.randomization import FACTORS
from spiraltrunk.envs.register import IDS
from spiraltrunk.sim.photographer import CAMERAS

PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "environments.md").read_text(encoding="utf-8")


def list_rows(title):
    """First cells of the table with a title."""
    table = PAGE.split(f"| {title} |")[1].split("\n\n")[0]
    return [line.split("|")[1] for line in table.splitlines()[2:]]


def expand(title, names):
    """Names that the rows cover, in order; a row covers one name, or all from one to another."""
    told = []
    for cell in list_rows(title):
        ends = [names.index(name) for name in re.findall(r"`(\w+)`", cell)]
        told += names[ends[0] : ends[-1] + 1]
    return told


def test_every_number_of_an_observation_is_told_in_order():
    names = list(agent_names(presets.PAPER))
    assert expand("numbers of `agent_pos`", names) == names
    names = list(environment_names())
    assert expand("numbers of `environment_state`", names) == names


def test_every_mode_environment_and_argument_is_told():
    assert re.findall(r"`([\w-]+)`", " ".join(list_rows("`control_mode`"))) == [mode.value for mode in ControlMode]
    assert re.findall(r"`([\w/-]+)`", " ".join(list_rows("environment"))) == list(IDS)
    told = set(re.findall(r"`(\w+)`", " ".join(list_rows("argument"))))
    assert told == set(inspect.signature(TrunkEnv).parameters) - {"job", "render_mode"}
    assert all(f"`{name}`" in PAGE for name in (*CAMERAS, *FACTORS))
