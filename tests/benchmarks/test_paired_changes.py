"""Pairs of trials with and without a change: which things are tried, what a variant changes, what is counted."""

import json

import pytest

from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.strategies.wrap import assess, standing_plan


@pytest.fixture
def pairs(load_benchmark):
    return load_benchmark("paired_changes")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("cylinder:diameter_mm=60,height_mm=180,mass_g=40", {"light"}),
        ("cylinder:diameter_mm=60,height_mm=180,mass_g=250", set()),
        ("box:x_mm=30,y_mm=30,z_mm=120,mass_g=40", {"slender"}),
        ("cylinder:diameter_mm=105,height_mm=112,mass_g=200", {"low-wide"}),
        ("cylinder:diameter_mm=105,height_mm=180,mass_g=200", {"tall-wide"}),
        ("cylinder:diameter_mm=39.5,height_mm=60,mass_g=40", {"near-fingers"}),
        ("cylinder:diameter_mm=43,height_mm=60,mass_g=40", set()),
        ("cylinder:diameter_mm=60,height_mm=180,mass_g=1700", {"heavy"}),
        ("cylinder:diameter_mm=60,height_mm=180,mass_g=4000", set()),
    ],
)
def test_each_set_has_the_things_that_it_says(pairs, text, expected):
    shape = parse_object(text)
    assert {name for name, own in pairs.SETS.items() if own.find(shape)} == expected


@pytest.mark.parametrize("name", ["light", "slender", "low-wide", "tall-wide", "near-fingers", "heavy"])
def test_variants_change_what_the_package_has(pairs, name):
    for patches in pairs.SETS[name].variants.values():
        for module, attribute, value in patches:
            assert getattr(module, attribute) != value


def test_a_variant_is_over_when_its_trial_fails(pairs):
    def read():
        return standing_plan.OPENED_TAIL, assess.SQUAT_HEIGHT

    def fail():
        with pairs.patched((pairs.BACK, pairs.ANY_HEIGHT)):
            raise ValueError(read())

    before = read()
    with pytest.raises(ValueError, match=r"0\.8, 1\.0"):
        fail()
    assert read() == before


def test_gains_and_losses_are_counted_in_pairs(pairs):
    def row(*good):
        names = ("new", "old")
        tries = {name: {"success": each, "held": True} for name, each in zip(names, good, strict=True)}
        return tries | {"scores": {"new": 0.5, "old": 0.25}}

    rows = [row(True, False)] * 3 + [row(False, True), row(True, True)]
    new, old = pairs.summarize(rows, ["new", "old"]).splitlines()
    assert new == "new: 4 of 5 succeed, 5 held; the scores add up to 2.5"
    assert old.startswith("old: 2 of 5 succeed, 5 held; the scores add up to 1.2; 'new' gains 3 and loses 1")
    assert old.endswith("p = 0.62)")


def test_what_was_tried_is_not_tried_again_and_a_line_that_was_cut_off_is(pairs, tmp_path, monkeypatch, capsys):
    tried = []

    def run_jobs(work, seeds, workers):
        for seed in seeds:
            tried.append(seed)
            outcome = {"success": seed == 2, "held": True, "reason": "toppled"}
            result = {"seed": seed, "object": "x", "scores": {"tried": 1.0}, "tried": outcome}
            yield type("Outcome", (), {"job": seed, "fault": None, "result": None if seed == 1 else result})

    monkeypatch.setattr(pairs, "run_jobs", run_jobs)
    log = tmp_path / "low-wide.jsonl"
    kept = {"seed": 0, "object": "y", "scores": {"tried": 1.0}, "tried": {"success": True, "held": True}}
    log.write_text(json.dumps(kept) + '\n{"seed": 1, "obj')
    command = ["--set", "low-wide", "--start", "0", "--objects", "3", "--out", str(tmp_path)]
    assert pairs.main(command) == 0
    assert tried == [1, 2]
    assert "tried: 2 of 2 succeed" in capsys.readouterr().out
    assert [json.loads(line)["seed"] for line in log.read_text().splitlines()] == [0, 1, 2]
    assert pairs.main(command) == 0
    assert tried == [1, 2]


@pytest.mark.parametrize("arguments", [["--set", "round"], ["--set", "light", "--objects", "nan"]])
def test_bad_arguments_get_one_line(pairs, arguments, tmp_path, capsys):
    with pytest.raises(SystemExit) as stop:
        pairs.main([*arguments, "--out", str(tmp_path)])
    assert stop.value.code == 2
    assert arguments[-1] in capsys.readouterr().err
