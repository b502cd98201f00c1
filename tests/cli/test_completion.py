"""``spiraltrunk completion``: the shells accept the scripts, and bash completes verbs and options."""

from __future__ import annotations

import json
import shutil
import subprocess

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
    ("typed", "expected"), [("val", ["validate"]), ("shape --dor", ["--dorsal-mm"]), ("completion z", ["zsh"])]
)
def test_bash_completes(typed: str, expected: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    program = COMPLETE.format(script=read("bash", capsys), typed=typed, position=len(typed.split()))
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == expected, done.stderr


def test_json_holds_the_script(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["completion", "bash", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["shell"] == "bash"
    assert f"{printed['script']}\n" == read("bash", capsys)


def test_another_shell_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["completion", "cmd"]) == 2
    assert "'bash', 'zsh', 'fish'" in capsys.readouterr().err
