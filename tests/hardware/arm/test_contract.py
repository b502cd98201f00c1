"""The contract of arms, on joints alone and on both drivers over stand-ins for their libraries."""

import pytest
from arm_bench import make_bench
from arm_contract import *  # noqa: F403


@pytest.fixture(params=["kinematic", "panda", "franky"])
def arm_bench(request, monkeypatch):
    bench = make_bench(request.param, monkeypatch)
    yield bench
    bench.arm.close()
