"""A policy cloned from recorded episodes of one strategy: description, networks and losses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.control.encoding import action_names
from spiraltrunk.control.strategy import SCENE_FIELDS, Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.files.results import read_versions
from spiraltrunk.strategies.policy.description import Layers, PolicyDescription
from spiraltrunk.strategies.policy.memory import MODE, list_inputs
from spiraltrunk.strategies.policy.network import Network
from spiraltrunk.strategies.wrap.hung import LEAD
from spiraltrunk.workflows.learn.cloning import Clone, CloningOptions, fit_clone
from spiraltrunk.workflows.learn.episodes import Episode
from spiraltrunk.workflows.learn.samples import Timing, list_stages, sample_episode

LATCHES = ("put back", "rise on", "lift", "bring")
"""Actions of a hung wrap at whose start the load is remembered (ours): what was weighed decides what follows."""


@final
@dataclass(frozen=True, kw_only=True)
class ClonedPolicy:
    """A cloned policy, not yet written."""

    description: PolicyDescription
    """What its networks take and give."""
    networks: dict[str, Network]
    """The networks "action" and "stage"."""
    clone: Clone
    """Networks with their losses."""


def clone_policy(
    episodes: Sequence[Episode],
    strategy: Strategy[Any],
    *,
    options: CloningOptions | None = None,
    timing: Timing | None = None,
    on_check: Callable[[str, int, float, float], None] | None = None,
) -> ClonedPolicy:
    """Clone the strategy that the episodes show; failed ones are left out.

    Raises:
        DesignError: where no episode is a success, and for successes of different trunks or arms.
        MissingPackage: without PyTorch.
    """
    options, timing = options or CloningOptions(), timing or Timing()
    shown = [episode for episode in episodes if episode.is_success]
    if not shown:
        raise DesignError("episodes", got=Unquoted("none that is a success"), allowed="one success or more")
    design, n_arm = _find_robot(shown)
    stages = list_stages(shown)
    latches = tuple(s.name for s in stages if s.name.split(": ")[-1].partition(" (")[0] in LATCHES)
    names = list_inputs(design, tuple(stage.name for stage in stages), n_arm)
    clone = fit_clone(
        [sample_episode(each, stages, latches, timing) for each in shown], names, options, on_check=on_check
    )
    networks = {"action": clone.action.network, "stage": clone.stage.network}
    description = PolicyDescription(
        control_mode=MODE.value, inputs=names, outputs=action_names(MODE, design), stages=stages,
        networks={key: Layers(sizes=network.sizes) for key, network in networks.items()},
        n_cable=design.n_cable, latches=latches, period=timing.period, smoothing=timing.smoothing,
        ventral_lead=LEAD,  # As demonstrated: it is not learned.
        widths=strategy.widths(design),
        provenance=_describe_provenance(shown, strategy, options),
        **{key: getattr(strategy, key) for key in SCENE_FIELDS},
    )  # fmt: skip
    return ClonedPolicy(description=description, networks=networks, clone=clone)


def _find_robot(shown: Sequence[Episode]) -> tuple[TrunkDesign, int]:
    """Trunk of the episodes, and the number of the arm's joints.

    Raises:
        DesignError: where they differ.
    """
    design, n_arm = shown[0].task.design, len(shown[0].observations[0].arm_position)
    for episode in shown:
        other, joints = episode.task.design, len(episode.observations[0].arm_position)
        if other != design or joints != n_arm:
            told = f"of the trunks {design.name!r} and {other.name!r}, which differ"
            if other == design:
                told = f"with arms of {n_arm} and of {joints} joints"
            raise DesignError("episodes", got=Unquoted(told), allowed="demonstrations of one trunk on one arm")
    return design, n_arm


def _describe_provenance(shown: Sequence[Episode], strategy: Strategy[Any], options: CloningOptions) -> dict[str, Any]:
    return {
        "method": "behaviour cloning", "demonstrated": strategy.name, "demonstrations": len(shown),
        "seeds": [episode.seed for episode in shown], "training_seed": options.seed,
        "versions": read_versions("mujoco", "numpy", "torch"), "design": shown[0].task.design.name,
    }  # fmt: skip
