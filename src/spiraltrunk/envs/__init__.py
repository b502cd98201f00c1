"""Gymnasium environments: ``import spiraltrunk.envs`` registers Grasp-v0, Kick-v0 and Sweep-v0 of "spiraltrunk/"."""

from spiraltrunk.envs.register import register_envs
from spiraltrunk.envs.strategy_agent import StrategyAgent, drive
from spiraltrunk.envs.trunk_env import TrunkEnv

register_envs()

__all__ = ["StrategyAgent", "TrunkEnv", "drive"]
