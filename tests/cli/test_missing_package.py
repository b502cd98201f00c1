"""A package that is missing is one line with the command that installs it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from spiraltrunk import cli
from spiraltrunk.cli import missing_package
from spiraltrunk.cli.missing_package import describe_missing


@pytest.mark.parametrize(
    ("module", "command"),
    [
        ("mujoco", "pip install 'mujoco"), ("PIL.Image", "pip install 'pillow"),
        ("fast_simplification", "pip install 'fast-simplification"), ("matplotlib.pyplot", "pip install 'matplotlib"),
        ("build123d", "pip install 'spiraltrunk[cad]'"), ("ezc3d", "pip install 'spiraltrunk[mocap]'"),
        ("coacd", "pip install 'spiraltrunk[objects]'"), ("glfw", "pip install --force-reinstall spiraltrunk"),
    ],
)  # fmt: skip
def test_the_command_is_of_the_package_or_its_extra(module: str, command: str) -> None:
    told = describe_missing(module)
    assert told.startswith(f"the package {module.partition('.')[0]!r} is not installed: ")
    assert command in told


def test_without_metadata_all_is_installed_again(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(name: str) -> None:
        raise missing_package.PackageNotFoundError(name)

    monkeypatch.setattr(missing_package, "requires", fail)
    assert describe_missing("mujoco").endswith("pip install --force-reinstall spiraltrunk")


@pytest.mark.parametrize(
    ("package", "arguments"),
    [("matplotlib", ["shape", "--dorsal-mm", "30", "--plot", "shape.png"]), ("mink", ["grasp", "kick", "--no-video"]),
     pytest.param("trimesh", ["export", "--parts", "horn", "--formats", "stl", "--out", "out"],
                  marks=pytest.mark.slow)],
)  # fmt: skip
def test_a_verb_without_its_package_is_one_line(package: str, arguments: list[str], tmp_path: Path) -> None:
    """A process of its own: here the package is loaded."""
    code = (
        f"import sys; sys.modules[{package!r}] = None; from spiraltrunk.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 2
    error = done.stderr.splitlines()[-1]
    assert error.startswith(f"spiraltrunk: error: the package '{package}' is not installed: pip install '{package}")
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_a_module_of_this_package_that_is_missing_is_a_bug(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(arguments: object) -> None:
        raise ModuleNotFoundError(name="spiraltrunk.model.lost")

    monkeypatch.setattr("spiraltrunk.cli.verbs.shape._run", fail)
    with pytest.raises(ModuleNotFoundError):
        cli.main(["shape", "--dorsal-mm", "30"])
