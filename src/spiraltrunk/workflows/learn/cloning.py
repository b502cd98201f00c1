"""Behaviour cloning: networks of a policy fitted to samples of demonstrations with PyTorch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, final

import numpy as np

from spiraltrunk.checks import check_count, check_number, check_type
from spiraltrunk.errors import MissingPackage
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.strategies.policy.description import LARGEST_LAYER
from spiraltrunk.strategies.policy.network import LARGEST_INPUT, Network
from spiraltrunk.workflows.learn.samples import Samples

_KNOWN = ("target", "goal", "seen", "latched_")
"""Inputs of both networks, by their prefix: object and goal, and the load at the start of a stage."""

USED = {"action": (*_KNOWN, "stage_"), "stage": (*_KNOWN, "stage_is", "stage_time", "load_", "cable_")}
"""Inputs that each network depends on (ours). Set points that depend on the measured motion of the arm or on the
forces of the moment feed back on themselves: in trials the arm began to swing until it passed its limits."""

LEAST_SCALE = 1e-3
"""Least scale of an input or output [its unit] (ours), for numbers that were all but constant in training."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CloningOptions:
    """Options of the training."""

    hidden: tuple[int, ...] = (128, 128)
    """Units of each hidden layer."""
    steps: int = 16_000
    """Most updates of each network."""
    batch: int = 256
    """Samples of an update."""
    rate: float = 2e-3
    """Learning rate at the start, which falls to 0 as a cosine."""
    decay: float = 1e-5
    """Weight decay (AdamW)."""
    check: int = 250
    """Updates between two checks of the validation loss."""
    patience: int = 8
    """Checks without a better validation loss after which training stops."""
    noise: float = 0.02
    """Standard deviation of noise on the normalised inputs [-]."""
    start_noise: float = 0.004
    """Standard deviation of noise on the encoded set point from which a stage begins [-]: the policy learns to come
    back to its way."""
    validation: float = 0.15
    """Share of the episodes that are kept for validation."""
    seed: int = 0
    """Seed of split, weights, batches and noise."""

    def __post_init__(self) -> None:
        check_type("cloning.hidden", self.hidden, tuple)
        for size in self.hidden:
            check_count("cloning.hidden", size, least=1, most=LARGEST_LAYER)
        for name in ("steps", "batch", "check", "patience"):
            check_count(f"cloning.{name}", getattr(self, name), least=1, most=10**9)
        check_count("cloning.seed", self.seed, least=0, most=2**63 - 1)
        check_number("cloning.rate", self.rate, above=0.0)
        for name in ("decay", "noise", "start_noise"):
            check_number(f"cloning.{name}", getattr(self, name), least=0.0)
        check_number("cloning.validation", self.validation, least=0.0, below=1.0)


@final
@dataclass(frozen=True, kw_only=True)
class Fit:
    """A fitted network and its losses."""

    network: Network
    """The network of the least validation loss."""
    steps: list[int] = field(default_factory=list)
    """Updates at which the losses were measured."""
    train: list[float] = field(default_factory=list)
    """Loss of the training batches since the last check."""
    valid: list[float] = field(default_factory=list)
    """Loss of the validation episodes."""


@final
@dataclass(frozen=True, kw_only=True)
class Clone:
    """A fitted policy's networks."""

    action: Fit
    """Network of the set points; its loss is the mean squared error of the normalised outputs."""
    stage: Fit
    """Network of the stages; its loss is the cross entropy."""
    validated: tuple[int, ...]
    """Indices of the episodes kept for validation."""


def split_episodes(count: int, share: float, seed: int) -> tuple[list[int], list[int]]:
    """Indices of the episodes to train with and to validate with, at least one each where there are two."""
    order = np.random.default_rng(seed).permutation(count).tolist()
    kept = min(max(1, round(share * count)), count - 1) if count > 1 else 0
    return sorted(order[kept:]), sorted(order[:kept] or order)


def fit_clone(
    episodes: Sequence[Samples],
    names: Sequence[str],
    options: CloningOptions | None = None,
    *,
    on_check: Callable[[str, int, float, float], None] | None = None,
) -> Clone:
    """Fit the networks "action" and "stage" to episodes; equal seeds give equal networks on one machine.

    Args:
        episodes: samples by episode; the split into training and validation is by episode.
        names: names of the inputs.
        options: options of the training.
        on_check: called at each check with the network's name, the update, and both losses.

    Raises:
        MissingPackage: without PyTorch.
    """
    options = CloningOptions() if options is None else options
    train, valid = split_episodes(len(episodes), options.validation, options.seed)
    starts = np.array([name.startswith("stage_start_") and "pull" not in name for name in names])
    used = {key: np.array([name.startswith(begins) for name in names]) for key, begins in USED.items()}
    sides = tuple([episodes[i] for i in part] for part in (train, valid))

    def fit(name: str, inputs: str, wanted: str) -> Fit:
        pairs = [tuple(np.concatenate([getattr(s, key) for s in side]) for key in (inputs, wanted)) for side in sides]
        data = _prepare(import_torch(), pairs[0], pairs[1], options, starts, used[name])
        return _fit(data, options, lambda step, now, then: on_check(name, step, now, then) if on_check else None)

    action, stage = fit("action", "now", "goal"), fit("stage", "before", "stage")
    return Clone(action=action, stage=stage, validated=tuple(valid))


def import_torch() -> Any:
    """PyTorch.

    Raises:
        MissingPackage: where it is not installed.
    """
    try:
        import torch
    except ImportError:
        raise MissingPackage("the package 'torch' is not installed: pip install 'spiraltrunk[learn]'") from None
    return torch


def _moments(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return values.mean(axis=0), np.maximum(values.std(axis=0), LEAST_SCALE)


@final
@dataclass(frozen=True, kw_only=True)
class _Data:
    """Normalised samples as tensors."""

    x: Any
    """Inputs to train with."""
    y: Any
    """What is wanted for them."""
    x_valid: Any
    """Inputs to validate with."""
    y_valid: Any
    """What is wanted for them."""
    spread: Any
    """Standard deviation of the noise on each input [-]."""
    used: np.ndarray
    """Inputs that the network depends on."""
    moments: dict[str, np.ndarray]
    """Means and scales of inputs and outputs."""


def _prepare(
    torch: Any,
    train: tuple[Any, ...],
    valid: tuple[Any, ...],
    options: CloningOptions,
    *which: np.ndarray,
) -> _Data:
    """Normalised samples; ``which`` are the inputs with the noise of set points, and those that are used."""
    starts, used = which
    is_class = train[1].ndim == 1
    mean, scale = _moments(train[0])
    n_out = int(max(train[1].max(), valid[1].max())) + 1 if is_class else train[1].shape[1]
    out_mean, out_scale = (np.zeros(n_out), np.ones(n_out)) if is_class else _moments(train[1])
    noise = options.noise * (train[0].std(axis=0) > LEAST_SCALE)
    noise[starts] = options.start_noise / scale[starts]
    noise[~used] = 0.0

    def normalise(inputs: np.ndarray, wanted: np.ndarray) -> tuple[Any, Any]:
        bounded = used * np.clip((inputs - mean) / scale, -LARGEST_INPUT, LARGEST_INPUT)
        x = torch.tensor(bounded, dtype=torch.float32)
        y = torch.tensor(wanted) if is_class else torch.tensor((wanted - out_mean) / out_scale, dtype=torch.float32)
        return x, y

    x, y = normalise(*train)
    x_valid, y_valid = normalise(*valid)
    moments = {"input_mean": mean, "input_scale": scale, "output_mean": out_mean, "output_scale": out_scale}
    spread = torch.tensor(noise, dtype=torch.float32)
    return _Data(x=x, y=y, x_valid=x_valid, y_valid=y_valid, spread=spread, used=used, moments=moments)


def _fit(data: _Data, options: CloningOptions, on_check: Callable[[int, float, float], None]) -> Fit:
    """Fit one network: AdamW with a cosine schedule, stopped early by the validation loss."""
    torch = import_torch()
    torch.manual_seed(options.seed)
    torch.set_num_threads(1)
    rng = np.random.default_rng(options.seed)
    compute_loss = torch.nn.MSELoss() if data.y.is_floating_point() else torch.nn.CrossEntropyLoss()
    model = _build_model(torch, (data.x.shape[1], *options.hidden, len(data.moments["output_mean"])))
    optimiser = torch.optim.AdamW(model.parameters(), lr=options.rate, weight_decay=options.decay)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, options.steps)
    best, kept, waited = np.inf, _copy(model), 0
    fit: dict[str, list[Any]] = {"steps": [], "train": [], "valid": []}
    recent: list[float] = []
    for step in range(1, options.steps + 1):
        chosen = torch.from_numpy(rng.integers(len(data.x), size=options.batch))
        noise = torch.randn(options.batch, data.x.shape[1]) * data.spread
        loss = compute_loss(model(data.x[chosen] + noise), data.y[chosen])
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
        recent.append(float(loss.detach()))
        if step % options.check and step != options.steps:
            continue
        with torch.no_grad():
            now = float(compute_loss(model(data.x_valid), data.y_valid))
        for key, value in (("steps", step), ("train", float(np.mean(recent))), ("valid", now)):
            fit[key].append(value)
        on_check(step, fit["train"][-1], now)
        recent.clear()
        best, kept, waited = (now, _copy(model), 0) if now < best else (best, kept, waited + 1)
        if waited >= options.patience:
            break
    kept[0] = kept[0] * data.used
    return Fit(network=_export(kept, data.moments), **fit)


def _copy(model: Any) -> list[np.ndarray]:
    return [each.detach().numpy().copy() for each in model.parameters()]


def _build_model(torch: Any, sizes: tuple[int, ...]) -> Any:
    layers: list[Any] = []
    for before, after in pairwise(sizes):
        layers += [torch.nn.Linear(before, after), torch.nn.ReLU()]
    return torch.nn.Sequential(*layers[:-1])


def _export(parameters: Sequence[np.ndarray], moments: dict[str, np.ndarray]) -> Network:
    return Network(
        weights=tuple(each.astype(float) for each in parameters[::2]),
        biases=tuple(each.astype(float) for each in parameters[1::2]),
        activation="relu", output="linear", **{name: value.astype(float) for name, value in moments.items()},
    )  # fmt: skip
