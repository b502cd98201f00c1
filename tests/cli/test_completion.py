"""``spiraltrunk completion``: the shells accept the scripts, and bash completes verbs and options."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from spiraltrunk import cli
from spiraltrunk.cli.verbs.completion import SHELLS

COMPLETE = """
{script}
spec=$(complete -p spiraltrunk); function=${{spec##*-F }}; function=${{function%% *}}
COMP_WORDS=(spiraltrunk {typed}); COMP_CWORD={position}
$function spiraltrunk "${{COMP_WORDS[$COMP_CWORD]}}" "${{COMP_WORDS[$COMP_CWORD-1]}}"
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def read(shell: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert cli.main(["completion", shell]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("shell", SHELLS)
def test_the_shell_accepts_its_script(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    script = read(shell, capsys)
    for word in ("calibrate", "virtual", "survey", "workers"):
        assert word in script
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=script, text=True, check=True, timeout=60)


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("val", ["validate"]),
        ("shape --dor", ["--dorsal-mm"]),
        ("completion z", ["zsh"]),
        ("shape own", ["own.toml"]),
        ("grasp --design own", ["own.toml"]),
        ("grasp --design paper-", ["paper-large-grip"]),
        ("grasp pin", ["pinch"]),
        ("survey --strategies au", ["auto"]),
        ("object bottle", ["bottle-70"]),
        ("drive rep", ["replay"]),
        ("drive replay own", ["own.toml"]),
        ("validate own", ["own.toml"]),
    ],
)
def test_bash_completes(
    typed: str,
    expected: list[str],
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / "own.toml").touch()
    monkeypatch.chdir(tmp_path)
    program = COMPLETE.format(script=read("bash", capsys), typed=typed, position=len(typed.split()))
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == expected, done.stderr


def test_bash_completes_files_where_nothing_is_offered(capsys: pytest.CaptureFixture[str]) -> None:
    program = f"{read('bash', capsys)}\ncomplete -p spiraltrunk"
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert " -o default " in done.stdout


def test_json_holds_the_script(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["completion", "bash", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["shell"] == "bash"
    assert f"{printed['script']}\n" == read("bash", capsys)


def test_another_shell_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["completion", "cmd"]) == 2
    assert "'bash', 'zsh', 'fish'" in capsys.readouterr().err
