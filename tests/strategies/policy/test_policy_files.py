"""Files of policies: whatever is wrong with them, one clear line, and nothing in them is run or allocated unseen."""

from __future__ import annotations

import json
import os
import pickle
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from spiraltrunk import cli
from spiraltrunk.control.strategy import SCENE_FIELDS
from spiraltrunk.errors import DesignError, SpiralTrunkError
from spiraltrunk.strategies.action_policy import ActionPolicy
from spiraltrunk.strategies.policy import policy_files
from spiraltrunk.strategies.policy.description import PolicyDescription
from spiraltrunk.strategies.policy.library import describe_policies, get_policy
from spiraltrunk.strategies.policy.network import Network
from spiraltrunk.strategies.policy.policy_files import compute_digest, load_policy, write_policy


def put(path: Path, data: bytes) -> None:
    """Replace the weights, and let the description name them."""
    import hashlib

    path.write_bytes(data)
    change_text(path, lambda values: values | {"weights_sha256": hashlib.sha256(data).hexdigest()})


def change_text(path: Path, change: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    text = path.with_suffix(".json")
    text.write_text(json.dumps(change(json.loads(text.read_text()))))


def refuse(path: Path) -> str:
    with pytest.raises(SpiralTrunkError) as caught:
        load_policy(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("size", [0, 5, 100, -10])
def test_truncated_weights(policy_file: Path, size: int) -> None:
    put(policy_file, policy_file.read_bytes()[:size])
    assert "truncated" in refuse(policy_file) or "damaged" in refuse(policy_file)


def test_exchanged_weights(policy_file: Path) -> None:
    data = bytearray(policy_file.read_bytes())
    data[-1] ^= 1
    policy_file.write_bytes(data)
    assert "not the file that its JSON file describes" in refuse(policy_file)


def test_missing_files(policy_file: Path, tmp_path: Path) -> None:
    assert "exists" in refuse(tmp_path / "none.safetensors")
    policy_file.with_suffix(".json").unlink()
    told = refuse(policy_file)
    assert "small.json' is a file that cannot be read: " in told
    assert told.endswith("; allowed: the JSON file that `learn` writes beside small.safetensors")


def test_what_the_description_lacks_is_told_once(policy_file: Path) -> None:
    change_text(policy_file, lambda values: values | {"format": "other"})
    told = refuse(policy_file)
    assert told.endswith("small.json': policy.format is another; allowed: spiraltrunk policy 1")
    assert told.count("allowed") == 1


def test_other_ending_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "weights.pkl"
    path.write_bytes(pickle.dumps({"a": 1}))
    assert ".safetensors" in refuse(path)


def test_pickle_is_never_loaded(policy_file: Path, tmp_path: Path) -> None:
    class Bomb:
        def __reduce__(self) -> tuple[Any, ...]:
            return os.mkdir, (str(tmp_path / "ran"),)

    put(policy_file, pickle.dumps(Bomb()))
    refuse(policy_file)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_weights_that_are_not_finite(
    description: PolicyDescription, networks: dict[str, Network], tmp_path: Path, value: float
) -> None:
    bad = networks["action"].biases[0].copy()
    bad[0] = value
    action = replace(networks["action"], biases=(bad, *networks["action"].biases[1:]))
    write_policy(tmp_path / "bad.safetensors", description, networks | {"action": action})
    assert "action.0.bias that is not finite" in refuse(tmp_path / "bad.safetensors")


def test_scale_of_zero(description: PolicyDescription, networks: dict[str, Network], tmp_path: Path) -> None:
    action = replace(networks["action"], input_scale=np.zeros_like(networks["action"].input_scale))
    write_policy(tmp_path / "bad.safetensors", description, networks | {"action": action})
    assert "not above 0" in refuse(tmp_path / "bad.safetensors")


def test_wrong_shapes_and_tensors(description: PolicyDescription, networks: dict[str, Network], tmp_path: Path) -> None:
    path = tmp_path / "bad.safetensors"
    write_policy(path, description, networks | {"stage": networks["action"]})
    assert "the tensor 'stage." in refuse(path)
    short = replace(networks["stage"], biases=(np.zeros(2),))
    write_policy(path, description, networks | {"stage": short})
    assert "stage.0.bias of shape (2,)" in refuse(path)


def test_claims_of_ten_gigabytes(policy_file: Path) -> None:
    header = json.dumps({"a": {"dtype": "F32", "shape": [50_000, 50_000], "data_offsets": [0, 10**10]}}).encode()
    put(policy_file, struct.pack("<Q", len(header)) + header + b"\0" * 8)
    assert "damaged" in refuse(policy_file)
    put(policy_file, struct.pack("<Q", 10**10) + b"{}")
    assert "truncated" in refuse(policy_file)
    put(policy_file, struct.pack("<Q", 2**63 + 5) + b"{}")
    assert "truncated" in refuse(policy_file)
    with policy_file.open("wb") as file:  # Sparse.
        file.truncate(10**10)
    assert "too large" in refuse(policy_file)


def test_numbers_of_another_type(policy_file: Path) -> None:
    header = json.dumps({"a": {"dtype": "F16", "shape": [1], "data_offsets": [0, 2]}}).encode()
    put(policy_file, struct.pack("<Q", len(header)) + header + b"\0\0")
    assert "F32" in refuse(policy_file)


def test_pipe_is_not_waited_for(policy_file: Path) -> None:
    policy_file.unlink()
    os.mkfifo(policy_file)
    assert "no regular file" in refuse(policy_file)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda values: values | {"format": "another"}, "spiraltrunk policy 1"),
        (lambda values: values | {"stranger": 1}, "stranger"),
        (lambda values: values | {"inputs": values["inputs"][1:]}, "networks"),
        (lambda values: values | {"inputs": values["inputs"][:1] * 2}, "a name twice"),
        (lambda values: values | {"outputs": 5}, "misstated"),
        (lambda values: values | {"control_mode": "dance"}, "pose-tension"),
        (lambda values: values | {"period": 0}, "period"),
        (lambda values: values | {"period": "soon"}, "period"),
        (lambda values: values | {"networks": {}}, "networks"),
        (lambda values: values | {"networks": {"action": {"sizes": [10**9, 1]}}}, "2048"),
        (lambda values: values | {"stages": [{"name": "a", "phase": "b"}]}, "phase"),
        (lambda values: values | {"latches": ["none"]}, "latches"),
        (lambda values: values | {"job": "cook"}, "kick"),
        (lambda values: values | {"objects": []}, "objects"),
        (lambda values: values | {"objects": "ab"}, "policy.objects is 'ab'; allowed: tuple"),
        (lambda values: values | {"latches": "keep"}, "policy.latches is 'keep'; allowed: tuple"),
        (lambda values: values | {"stages": [{"name": "a", "phase": "reach", "after": "a"}]}, "policy.stages.after"),
        (lambda values: values | {"widths": [0.1]}, "two numbers"),
        (lambda values: values | {"push": 0.1}, "two numbers"),
        (lambda values: values | {"position": []}, "two numbers"),
        (lambda values: values | {"position": ""}, "two numbers"),
        (lambda values: values | {"position": 0}, "two numbers"),
        (lambda values: values | {"position": False}, "two numbers"),
        (lambda values: values | {"longest": 1e9}, "longest"),
        (lambda values: {}, "spiraltrunk policy 1"),
    ],
)  # fmt: skip
def test_bad_descriptions(policy_file: Path, change: Callable[[dict[str, Any]], dict[str, Any]], told: str) -> None:
    change_text(policy_file, change)
    assert told in refuse(policy_file)


@pytest.mark.parametrize("text", [b"", b"[]", b"{", b"\xff\xfe", b'{"period": NaN}', b"[" * 100_000])
def test_description_that_is_none(policy_file: Path, text: bytes) -> None:
    policy_file.with_suffix(".json").write_bytes(text)
    assert "small.json" in refuse(policy_file)


def test_large_description(policy_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(policy_files, "TEXT_MOST", 10)
    assert "too large" in refuse(policy_file)


def test_digest_covers_both_files(policy_file: Path) -> None:
    before = compute_digest(policy_file)
    change_text(policy_file, lambda values: values | {"longest": 60.0})
    assert compute_digest(policy_file) != before


def test_name_of_a_policy(policy_file: Path) -> None:
    strategy = get_policy(f"policy:{policy_file}")
    assert (strategy.name, strategy.objects, strategy.support) == (
        "policy:small.safetensors", ("cylinder-60", "box-60"), "hung",
    )  # fmt: skip


@pytest.mark.parametrize("verb", [("grasp",), ("survey", "--trials", "1", "--strategies")])
def test_command_line_refuses_in_one_line(
    verb: tuple[str, ...], policy_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    policy_file.write_bytes(policy_file.read_bytes()[:50])
    assert cli.main([*verb, f"policy:{policy_file}"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.strip().count("\n") == 0
    assert "small.safetensors" in told.err


def test_whatever_decides_on_the_scenes_is_taken_over(policy_file: Path) -> None:
    """Descriptions of earlier versions do not state whether the orientation was chosen for the object."""

    def leave_out(values: dict[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in values.items() if key != "has_fixed_orientation"}

    change_text(policy_file, leave_out)
    assert not get_policy(f"policy:{policy_file}").has_fixed_orientation
    change_text(policy_file, lambda values: values | {"has_fixed_orientation": True, "orientation": "upright"})
    strategy = get_policy(f"policy:{policy_file}")
    copy = ActionPolicy(lambda seen: np.zeros(10), strategy)
    for name in SCENE_FIELDS:
        assert getattr(strategy, name) == getattr(copy, name) == getattr(load_policy(policy_file)[0], name)
    assert copy.has_fixed_orientation


def test_the_home_folder_of_an_unknown_user_is_refused() -> None:
    name = "policy:~no-such-user/x.safetensors"
    for call in (get_policy, lambda given: describe_policies((given,))):
        with pytest.raises(DesignError, match="home folder of an unknown user"):
            call(name)
