"""Many worlds at once: the batch steps each world as MuJoCo alone does, and Warp is left out where it is absent."""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import mujoco
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def worlds() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "benchmarks")
        yield importlib.import_module("worlds_throughput")


@pytest.fixture(scope="module")
def recorded(worlds: ModuleType) -> tuple[mujoco.MjModel, Any]:
    return worlds.record(0.5)


def test_moments_are_those_of_the_grasp(recorded: tuple[mujoco.MjModel, Any]) -> None:
    model, moments = recorded
    assert moments.qpos.shape == (2, model.nq)
    assert moments.actuator_forcerange.shape == (2, model.nu, 2)
    assert np.ptp(moments.qpos, axis=0).max() > 0


def test_a_batch_steps_each_world_as_mujoco_alone(worlds: ModuleType, recorded: tuple[mujoco.MjModel, Any]) -> None:
    model, moments = recorded
    batch, own = worlds.build_batch(model, moments, 5, 2), moments.repeat(5)
    batch.step(nstep=worlds.STEPS)
    alone = [worlds.step_in_c(model, own, i, worlds.STEPS) for i in range(5)]
    assert np.array_equal(batch.bind("qpos"), alone)
    assert not np.array_equal(own.qpos, alone)


def test_rates_are_numbers_and_files_come_back(
    worlds: ModuleType, recorded: tuple[mujoco.MjModel, Any], tmp_path: Path
) -> None:
    model, moments = recorded
    worlds.save(tmp_path, model, moments)
    assert np.array_equal(worlds.load(tmp_path)[1].qpos, moments.qpos)
    rate = worlds.measure_job(worlds.Job(str(tmp_path), 2, 0.05))
    assert 0 < rate.per_s < float("inf")
    assert 0 < rate.per_processor_s < float("inf")


def test_without_warp_the_reason_is_told(
    worlds: ModuleType, recorded: tuple[mujoco.MjModel, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "mujoco_warp", None)
    told = worlds.run_warp(*recorded, argparse.Namespace())
    assert "not installed: pip install mujoco-warp==4.0.0" in told["skipped"]
