"""Observations of environments: their spaces, and the privileged true state.

`trunk_env.TrunkEnv` assembles an observation from these and from the vectors of `control.encoding`.
"""
