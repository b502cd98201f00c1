"""Pictures of states that are over are those that were taken then."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.control.messages import Command
from spiraltrunk.sim import SimPlant
from spiraltrunk.sim.photographer import CAMERAS, Photographer


@pytest.mark.gl
def test_a_posed_picture_is_the_one_of_that_moment() -> None:
    plant = SimPlant()
    seen = plant.reset()
    now, later = Photographer(plant, (48, 64)), Photographer(plant, (48, 64))
    try:
        taken, positions = [], []
        for _ in range(3):
            for _ in range(4):
                seen = plant.step(Command(T_world_base=seen.T_world_base, cable_tension=np.array([8.0, 0.0, 0.0])))
            positions.append(plant.data.qpos.copy())
            plant_pose = plant.trace[-1].qpos
            np.testing.assert_array_equal(plant_pose, positions[-1])
            now.pose(positions[-1])
            taken.append({camera: now.take(camera) for camera in CAMERAS})
        before = plant.data.qpos.copy()
        for pose, pictures in reversed(list(zip(positions, taken, strict=True))):
            later.pose(pose)
            for camera, picture in pictures.items():
                assert picture.shape == (48, 64, 3)
                np.testing.assert_array_equal(later.take(camera), picture)
        np.testing.assert_array_equal(plant.data.qpos, before)
        assert not np.array_equal(taken[0]["close"], taken[2]["close"])
        live = Photographer(plant, (48, 64))
        difference = np.abs(live.take("close").astype(int) - taken[2]["close"])
        live.close()
        assert np.quantile(difference, 0.99) <= 8  # The live state's tendons are of the step before.
    finally:
        now.close()
        later.close()
