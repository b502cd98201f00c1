"""Virtual takes of one run at rest, whose recording takes a moment."""

import pytest

from spiraltrunk.design import presets
from spiraltrunk.studio.measure import jobs

RUN = "rest-045"


@pytest.fixture(scope="session")
def virtual(tmp_path_factory):
    """Folder of a virtual session: ``rest-045_1.csv``, ``rest-045_2.csv`` and ``protocol.toml``."""
    folder = tmp_path_factory.mktemp("virtual") / "session"
    jobs.record_virtual(lambda _: None, presets.PAPER, RUN, 0, str(folder))
    return folder


@pytest.fixture(scope="session")
def question(virtual):
    """Comparison of that session with the paper's model."""
    files = sorted(str(file) for file in virtual.glob("*.csv"))
    return jobs.Question(
        design=presets.PAPER, protocol=str(virtual / "protocol.toml"), takes={RUN: files}, axes="y-up",
        model="reference", alignment="base",
    )  # fmt: skip
