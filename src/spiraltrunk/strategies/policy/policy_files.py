"""Files of a policy: weights as safetensors, and their description as JSON beside them; nothing in them is executed."""

from __future__ import annotations

import hashlib
import json
import os
import stat
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from spiraltrunk.errors import DesignError, SpiralTrunkError, UnknownName, Unquoted, describe_reason
from spiraltrunk.files.atomic import write_file, write_text
from spiraltrunk.strategies.policy.description import Layers, PolicyDescription, format_description, parse_description
from spiraltrunk.strategies.policy.network import Network

WEIGHTS_MOST, TEXT_MOST = 64_000_000, 1_000_000
"""Largest files of weights and of a description that are read [bytes] (ours)."""

SUFFIX = ".safetensors"
"""Ending of a file of weights."""

_HEADER_MOST = 1_000_000
"""Largest header of a file of weights [bytes]."""

_MOMENTS = ("input_mean", "input_scale", "output_mean", "output_scale")


def load_policy(path: str | Path) -> tuple[PolicyDescription, dict[str, Network]]:
    """Description and networks of a policy from its file of weights and the JSON file beside it.

    Raises:
        DesignError: in one line, where a file is missing, too large, damaged, or the two do not fit.
        UnknownName: for a value of the description that is not in a list.
    """
    place = Path(path)
    if place.suffix != SUFFIX:
        got = str(path) if place.name else Unquoted("no file")
        raise DesignError("policy", got=got, allowed=f"a file that ends in {SUFFIX}")
    data = _read_limited(place, WEIGHTS_MOST)
    description_file = place.with_suffix(".json")
    text = _read_limited(description_file, TEXT_MOST, f"the JSON file that `learn` writes beside {place.name}")
    try:
        description = parse_description(text.decode())
    except UnicodeDecodeError:
        raise _refuse(description_file, "no UTF-8 text", "the JSON file that `learn` writes") from None
    except DesignError as error:
        raise DesignError(error.name, got=error.got, allowed=error.allowed, file=str(description_file)) from None
    except UnknownName as error:
        raise _refuse(description_file, f"with {error.name!r}", f"of {', '.join(error.known)}") from None
    if description.weights_sha256 != hashlib.sha256(data).hexdigest():
        raise _refuse(place, "not the file that its JSON file describes", "both files as `learn` wrote them")
    return description, _build_networks(place, description, _parse_tensors(place, data))


def write_policy(path: str | Path, description: PolicyDescription, networks: Mapping[str, Network]) -> None:
    """Write weights and description; each file is replaced as a whole.

    Raises:
        OSError: where they cannot be written.
    """
    from safetensors.numpy import save

    place = Path(path)
    tensors = {name: value for key, network in networks.items() for name, value in _list_tensors(key, network).items()}
    data = save({name: np.ascontiguousarray(value, dtype=np.float32) for name, value in tensors.items()})
    write_file(place, data)
    told = replace(description, weights_sha256=hashlib.sha256(data).hexdigest())
    write_text(place.with_suffix(".json"), format_description(told))


def compute_digest(path: str | Path) -> str:
    """SHA-256 of a policy's two files, hexadecimal.

    Raises:
        DesignError: where one of them cannot be read.
    """
    place, digest = Path(path), hashlib.sha256()
    digest.update(_read_limited(place, WEIGHTS_MOST))
    digest.update(_read_limited(place.with_suffix(".json"), TEXT_MOST))
    return digest.hexdigest()


def _list_tensors(key: str, network: Network) -> dict[str, np.ndarray]:
    layers = enumerate(zip(network.weights, network.biases, strict=True))
    named = {f"{key}.{name}": getattr(network, name) for name in _MOMENTS}
    for i, (weight, bias) in layers:
        named |= {f"{key}.{i}.weight": weight, f"{key}.{i}.bias": bias}
    return named


def _list_shapes(key: str, layers: Layers) -> dict[str, tuple[int, ...]]:
    """Names and shapes of a network's tensors."""
    n_in, n_out = layers.sizes[0], layers.sizes[-1]
    shapes: dict[str, tuple[int, ...]] = {f"{key}.{name}": (n_in if "input" in name else n_out,) for name in _MOMENTS}
    for i, (before, after) in enumerate(zip(layers.sizes[:-1], layers.sizes[1:], strict=True)):
        shapes |= {f"{key}.{i}.weight": (after, before), f"{key}.{i}.bias": (after,)}
    return shapes


def _parse_tensors(place: Path, data: bytes) -> dict[str, np.ndarray]:
    """Tensors in the bytes of a file; the header, which may claim any size, is checked first."""
    from safetensors import SafetensorError
    from safetensors.numpy import load

    allowed = "a whole file that `learn` wrote"
    size = int.from_bytes(data[:8], "little")
    if len(data) < 8 or size > min(len(data) - 8, _HEADER_MOST):
        raise _refuse(place, "truncated, or no safetensors", allowed)
    try:
        header = json.loads(data[8 : 8 + size])
        kinds = {each["dtype"] for name, each in header.items() if name != "__metadata__"}
        if kinds - {"F32"}:
            raise _refuse(place, f"of {', '.join(sorted(map(str, kinds)))[:60]}", "numbers of type F32")
        return dict(load(data))
    except (SafetensorError, ValueError, TypeError, KeyError, AttributeError, RecursionError, MemoryError) as error:
        if isinstance(error, SpiralTrunkError):
            raise
        raise _refuse(place, f"damaged ({describe_reason(error)[:80]})", allowed) from None


def _build_networks(
    place: Path, description: PolicyDescription, tensors: Mapping[str, np.ndarray]
) -> dict[str, Network]:
    shapes = {
        name: shape for key, layers in description.networks.items() for name, shape in _list_shapes(key, layers).items()
    }
    if tensors.keys() != shapes.keys():
        differing = sorted(tensors.keys() ^ shapes.keys())[0]
        raise _refuse(place, f"with or without the tensor {differing[:60]!r}", "the tensors of its description")
    for name, shape in shapes.items():
        if tensors[name].shape != shape:
            raise _refuse(place, f"with {name} of shape {tensors[name].shape}", f"{shape}, as its description says")
        if not np.isfinite(tensors[name]).all():
            raise _refuse(place, f"with a number in {name} that is not finite", "finite numbers")
        if name.endswith("_scale") and not (tensors[name] > 0).all():
            raise _refuse(place, f"with a number in {name} that is not above 0", "scales above 0")
    return {key: _build_network(key, layers, tensors) for key, layers in description.networks.items()}


def _build_network(key: str, layers: Layers, tensors: Mapping[str, np.ndarray]) -> Network:
    def take(name: str) -> np.ndarray:
        return tensors[f"{key}.{name}"].astype(float)

    count = range(len(layers.sizes) - 1)
    return Network(
        weights=tuple(take(f"{i}.weight") for i in count), biases=tuple(take(f"{i}.bias") for i in count),
        activation=layers.activation, output=layers.output, **{name: take(name) for name in _MOMENTS},
    )  # fmt: skip


def _read_limited(path: Path, most: int, allowed: str = "a file that exists") -> bytes:
    """Content of a regular file of at most ``most`` bytes; opening a pipe or a device neither waits nor reads."""
    try:
        with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise _refuse(path, "no regular file", "a file")
            content = file.read(most + 1) if status.st_size <= most else b""
            if status.st_size > most or len(content) > most:
                raise _refuse(path, "too large", f"at most {most // 1_000_000} MB")
            return content
    except (OSError, ValueError) as error:
        if isinstance(error, SpiralTrunkError):
            raise
        raise _refuse(path, f"a file that cannot be read: {describe_reason(error)}", allowed) from None


def _refuse(path: Path, reason: str, allowed: str) -> DesignError:
    return DesignError(f"policy {str(path)!r}", got=Unquoted(reason), allowed=allowed)
