"""What is no design, no option, no load or no number is refused in one line."""

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.model import inverse, reference, statics
from spiraltrunk.model.inverse.solve import InverseOptions
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.loads import Loads

PAPER = presets.PAPER
TIP = (0.1, -0.3, 0.1)

REFUSED = {
    "design is": [
        lambda: statics.solve("paper"), lambda: inverse.solve("paper", TIP), lambda: reference.rest("paper", 1.0),
        lambda: inverse.follow("paper", np.zeros((18, 3))), lambda: inverse.curl("paper", TIP, 0.1),
    ],
    "loads is": [lambda: statics.solve(PAPER, loads=0.2), lambda: inverse.solve(PAPER, TIP, loads=np.zeros((2, 5)))],
    "loads.section is": [lambda: statics.solve(PAPER, loads=Loads(mass=0.1, section=np.zeros((9, 9))))],
    "start is": [lambda: statics.solve(PAPER, start=[])],
    "options is": [
        lambda: statics.solve(PAPER, options=1.0), lambda: inverse.solve(PAPER, TIP, options="all"),
        lambda: inverse.curl(PAPER, TIP, 0.1, options=3),
    ],
    "statics is": [lambda: InverseOptions(statics="all")],
    "quasi_static is": [lambda: StaticsOptions(quasi_static=1.0)],
    "tension is": [
        lambda: statics.solve(PAPER, tension="1.0"),
        lambda: statics.solve(PAPER, tension=[[1, 2], [3]]),
    ],
    "theta_0 is": [
        lambda: statics.solve(PAPER, theta_0=1e308), lambda: inverse.solve(PAPER, TIP, theta_0=1e308),
        lambda: reference.rest(PAPER, 1e300), lambda: reference.bend_dorsal(PAPER, 0.05, [0.0, -1e7]),
        lambda: reference.bend_dorsal_points(PAPER, [0.05], 1e300), lambda: reference.twist(PAPER, 0.0, 0.0, 1e300),
        lambda: statics.solve(PAPER, theta_0="1.0"), lambda: statics.solve(PAPER, theta_0=np.datetime64("2020")),
    ],
    "roll is": [lambda: inverse.solve(PAPER, TIP, roll=-1e308)],
    "direction_weight has": [
        lambda: inverse.solve(PAPER, TIP, direction=(1, 0, 0), direction_weight=[]),
        lambda: inverse.solve(PAPER, TIP, direction=(1, 0, 0), direction_weight=[1, 2, 3]),
    ],
    "diameter is": [
        lambda: inverse.curl(PAPER, TIP, "1.0"),
        lambda: inverse.curl(PAPER, TIP, np.zeros((2, 2, 2, 2, 3))),
    ],
    "touching is": [lambda: inverse.curl(PAPER, TIP, 0.1, touching=100)],
    "friction is": [lambda: statics.solve(PAPER, friction=np.zeros((50, 3)))],
    "targets, theta_0, roll and loads": [
        lambda: inverse.solve(PAPER, TIP, theta_0=[]), lambda: inverse.solve(PAPER, TIP, loads=Loads(mass=[])),
        lambda: inverse.curl(PAPER, np.empty((0, 3)), 0.1), lambda: inverse.curl(PAPER, TIP, []),
    ],
}  # fmt: skip


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("said", "ask"), [(said, ask) for said, asked in REFUSED.items() for ask in asked])
def test_it_is_refused_in_one_line(said, ask):
    with pytest.raises(SpiralTrunkError) as caught:
        ask()
    line = str(caught.value)
    assert line.startswith(said)
    assert "; allowed: " in line
    assert "\n" not in line
    assert len(line) < 250


@pytest.mark.parametrize("name", ["paper", "spirob-15", "spirob-1m"])
def test_the_pull_of_an_inverse_holds_its_shape_when_it_starts_there(name):
    design = presets.get(name)
    tension = np.random.default_rng(5).uniform(0.0, 0.2 * design.cable.tension_max, (6, design.n_cable))
    tips = statics.solve(design, tension=tension, theta_0=1.0, roll=0.3, friction=0.0).points[:, -1]
    reach = inverse.solve(design, tips, theta_0=1.0, roll=0.3)
    again = statics.solve(design, pull=reach.pull, theta_0=1.0, roll=0.3, friction=0.0, start=reach.shape)
    assert np.abs(again.points - reach.points).max() < 1e-6 * design.length
