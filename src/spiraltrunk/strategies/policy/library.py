"""Policies by the name ``policy:FILE.safetensors``, which is accepted wherever a strategy's name is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from spiraltrunk.control.strategy import Strategy
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.strategies.policy.policy_files import compute_digest, load_policy
from spiraltrunk.strategies.policy.policy_strategy import PolicyStrategy
from spiraltrunk.strategies.policy.stroke_strategy import StrokeStrategy

PREFIX = "policy:"
"""Prefix of a policy's name."""

_NAME_MOST = 60
"""Length to which the name of a file is cut in the name of its policy."""


def is_policy(name: str) -> bool:
    """Whether a strategy's name is that of a policy's file."""
    return isinstance(name, str) and name.startswith(PREFIX)


def get_policy(name: str) -> Strategy[Any]:
    """The policy of a name ``policy:FILE.safetensors``, run without the package that trained it.

    Raises:
        DesignError: in one line, where its files cannot be used.
        UnknownName: for a value of its description that is not in a list.
    """
    path = _find_path(name)
    description, networks = load_policy(path)
    kind = StrokeStrategy if description.control_mode == "stroke" else PolicyStrategy
    shown = "".join(letter if letter.isprintable() else "?" for letter in path.name[:_NAME_MOST])
    return kind(f"{PREFIX}{shown}", description, networks)


def describe_policies(names: tuple[str, ...]) -> dict[str, str]:
    """Digest of the files of every policy among the names, by its name.

    Raises:
        DesignError: where a file cannot be read.
    """
    paths = {name: _find_path(name) for name in names if is_policy(name)}
    return {name: compute_digest(path) for name, path in paths.items()}


def _find_path(name: str) -> Path:
    """Path of the weights of a policy's name.

    Raises:
        DesignError: where it begins with the home folder of a user that does not exist.
    """
    path = Path(name.removeprefix(PREFIX))
    try:
        return path.expanduser()
    except RuntimeError:
        got = Unquoted(f"{str(path)!r}, in the home folder of an unknown user")
        raise DesignError("policy", got=got, allowed="the path of a file; ~/ is your own home folder") from None
