"""The command that opens the browser page, as a process."""

import json
import subprocess
import sys
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest

pytest.importorskip("viser", reason="viser is not installed")


def run_studio(*options):
    """Address that the studio prints, the status of its page with and without the token, and what it complains of."""
    command = [sys.executable, "-m", "spiraltrunk", "studio", "--port", "0", "--no-browser", "--json", *options]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as running:
        address = json.loads(running.stdout.readline())["address"]
        local = address.replace("0.0.0.0", "127.0.0.1")
        statuses = [read_status(one) for one in (local, local.partition("?")[0])]
        running.terminate()
        said = running.communicate(timeout=60)[1]
    return address, statuses, said.splitlines()


def read_status(address):
    try:
        with urlopen(address, timeout=60) as answer:
            return answer.status
    except HTTPError as error:
        return error.code


def test_another_host_is_told_and_needs_the_token():
    address, statuses, said = run_studio("--host", "0.0.0.0")
    assert "?token=" in address
    assert statuses == [200, 401]
    assert said[0] == ("spiraltrunk: others can reach this studio at 0.0.0.0: whoever has the address can use it")


def test_this_computer_alone_needs_neither():
    address, statuses, said = run_studio()
    assert address.startswith("http://127.0.0.1:")
    assert "token" not in address
    assert statuses == [200, 200]
    assert said == ["spiraltrunk: terminated"]
