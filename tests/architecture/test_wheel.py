"""The package as it is released: an sdist and a wheel, and the wheel at work where nothing else is installed."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

import spiraltrunk

ROOT = Path(__file__).parents[2]


def run(*command: str | Path, cwd: Path) -> str:
    environment = {name: value for name, value in os.environ.items() if name not in {"PYTHONPATH", "VIRTUAL_ENV"}}
    ran = subprocess.run(
        [str(part) for part in command], cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, f"{command}: {ran.stdout[-2000:]}{ran.stderr[-2000:]}"
    return ran.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the sdist and the wheel that is built from it, from the files that git knows or would add."""
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("dist")
    listed = run("git", "ls-files", "--cached", "--others", "--exclude-standard", "-z", cwd=ROOT).split("\0")
    for name in listed:
        if name and (ROOT / name).is_file() and not name.startswith("docs/"):
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", out, source, cwd=source)
    return out


def find_one(folder: Path, pattern: str) -> Path:
    found = list(folder.glob(pattern))
    assert len(found) == 1, found
    return found[0]


def test_wheel_holds_every_module_and_data_file(built: Path) -> None:
    with zipfile.ZipFile(find_one(built, "*.whl")) as wheel:
        held = set(wheel.namelist())
    package = ROOT / "src" / "spiraltrunk"
    wanted = {f"spiraltrunk/{path.relative_to(package).as_posix()}" for path in package.rglob("*.py")}
    wanted |= {"spiraltrunk/py.typed", "spiraltrunk/mocap/protocol/protocol.toml"}
    assert wanted <= held
    assert {name for name in held if not name.startswith("spiraltrunk")} == set()
    assert any(name.endswith("licenses/LICENSE") for name in held)


def test_sdist_holds_what_builds_it(built: Path) -> None:
    with tarfile.open(find_one(built, "*.tar.gz")) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "README.md", "LICENSE", "src/spiraltrunk/__init__.py"} <= held


@pytest.mark.slow
def test_wheel_runs_without_the_repository(built: Path, tmp_path: Path) -> None:
    """The wheel's files alone, beside the packages that are installed here."""
    site = tmp_path / "site"
    run(sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-index", "--target", site,
        find_one(built, "*.whl"), cwd=tmp_path)  # fmt: skip
    program = f"import sys; sys.path.insert(0, {str(site)!r}); import spiraltrunk; print(spiraltrunk.__file__)"
    assert run(sys.executable, "-c", program, cwd=tmp_path).startswith(str(site))
    told = run(sys.executable, "-c", program.replace("print(spiraltrunk.__file__)",
               "from spiraltrunk.cli import main; sys.exit(main(['design', '--json']))"), cwd=tmp_path)  # fmt: skip
    assert json.loads(told)["n_section"] == 18


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_wheel_in_an_empty_environment(built: Path, tmp_path: Path) -> None:
    """Installed with what it depends on and nothing else, it grasps, shapes and surveys."""
    venv.create(tmp_path / "env", with_pip=True)
    bin_folder = tmp_path / "env" / "bin"
    run(bin_folder / "pip", "install", "-q", "-c", ROOT / "constraints.txt", find_one(built, "*.whl"), cwd=tmp_path)
    command = bin_folder / "spiraltrunk"
    assert run(command, "--version", cwd=tmp_path).split() == ["spiraltrunk", spiraltrunk.__version__]
    assert json.loads(run(command, "shape", "--json", cwd=tmp_path))["status"]
    grasp = json.loads(run(command, "grasp", "--no-video", "--json", "--out", "grasp", cwd=tmp_path))
    assert grasp["success"]
    survey = json.loads(run(command, "survey", "--strategies", "kick", "--trials", "1", "--json", cwd=tmp_path))
    assert survey["strategies"]["kick"]["trials"] == 1
