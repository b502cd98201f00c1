"""
Drive an environment
====================

A Gymnasium environment of a kick, driven by the strategy, and saved and gone on with under way.

The environment draws its world as a trial of a survey does and judges by the survey's verdict. Here the strategy
chooses the actions; a learned policy would do so in the same loop.
"""

from __future__ import annotations

import gymnasium
import numpy as np

from spiraltrunk import strategies
from spiraltrunk.envs import StrategyAgent, TrunkEnv  # Registers the environments.

# %%
# The world of ``spiraltrunk grasp kick --object box-80 --seed 5``, with tensions and pulls as actions.
env = gymnasium.make("spiraltrunk/Kick-v0", control_mode="delta-pose-tension-pull")
base = env.unwrapped
assert isinstance(base, TrunkEnv)
seen, info = env.reset(options={"object": "box-80", "seed_world": 5})
print({name: value.shape for name, value in seen.items()}, env.action_space.shape)
print(f"{info['world']['mass_kg']:.3f} kg, friction {info['world']['friction']:.2f}")

# %%
# The strategy's commands as actions, until the box rests beyond the line.
agent = StrategyAgent(env, strategies.get("kick"))
agent.reset()
total, saved = 0.0, None
while True:
    action = agent.act()
    if saved is None and base.observation.time >= 1.0:
        saved, next_action = base.get_state(), action
    seen, reward, terminated, truncated, info = env.step(action)
    total += float(reward)
    if terminated or truncated:
        break
print(f"{info['reason']} after {info['time_s']:.1f} s, reward {total:.2f}, {info['reward_terms']}")
assert info["is_success"]
assert agent.clipped == 0.0

# %%
# A saved state goes on bit for bit, in another environment too.
assert saved is not None
twin = gymnasium.make("spiraltrunk/Kick-v0", control_mode="delta-pose-tension-pull").unwrapped
assert isinstance(twin, TrunkEnv)
ends = []
for each in (base, twin):
    each.set_state(saved)
    for _ in range(10):
        seen, *_ = each.step(next_action)
    ends.append(seen["agent_pos"])
assert np.array_equal(*ends)
