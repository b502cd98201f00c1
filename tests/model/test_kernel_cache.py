"""Machine code on disc: a package that cannot be written, a damaged cache, a folder of somebody else's."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import spiraltrunk
from spiraltrunk.model import kernel_cache

KERNEL = """
from spiraltrunk.model.jit import compiler
@compiler("STAMP", is_alone=True)
def double(x):
    return 2.0 * x
print(double(4.0))
"""
NOBODY = 65534


@pytest.fixture(scope="module")
def read_only_package() -> Iterator[Path]:
    """A copy of the package that nobody can write, without compiled files, in a folder that all can read."""
    folder = Path(tempfile.mkdtemp())  # pytest's own folders are closed to other users.
    package = folder / "spiraltrunk"
    shutil.copytree(Path(spiraltrunk.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    folder.chmod(0o755)
    for path in (package, *package.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    yield folder
    for path in package.rglob("*"):
        path.chmod(0o755)
    package.chmod(0o755)
    shutil.rmtree(folder)


def run_as_other_user(package: Path, temporary: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Python without a home folder; as another user where this process may become one."""
    command = [sys.executable, *arguments]
    if os.getuid() == 0:
        if shutil.which("setpriv") is None:
            pytest.skip("root may write read-only folders, and there is no setpriv to become somebody else")
        user = f"--reuid={NOBODY} --regid={NOBODY} --clear-groups --inh-caps=-all --bounding-set=-all"
        command = ["setpriv", *user.split(), *command]
    environment = {
        "PATH": os.environ["PATH"], "HOME": "/nonexistent", "PYTHONPATH": str(package),
        "PYTHONDONTWRITEBYTECODE": "1", "TMPDIR": str(temporary),
    }  # fmt: skip
    done = subprocess.run(command, env=environment, cwd="/", capture_output=True, text=True, check=False)
    if "Permission denied" in done.stderr and "spiraltrunk" not in done.stderr.partition("\n")[0]:
        pytest.skip(f"another user cannot run this Python: {done.stderr[-200:]}")
    return done


@pytest.mark.slow
def test_read_only_package_keeps_its_code_in_the_temporary_folder(read_only_package: Path) -> None:
    temporary = Path(tempfile.mkdtemp())
    temporary.chmod(0o777)
    shape = ("shape", "--dorsal-mm", "50", "--json")
    try:
        first = run_as_other_user(read_only_package, temporary, "-m", "spiraltrunk", *shape)
        assert first.returncode == 0, first.stderr
        assert json.loads(first.stdout)["status"]
        lines = first.stderr.splitlines()
        assert len(lines) == 2
        assert "compiled models are kept in" in lines[0]
        assert "compiling the models" in lines[1]
        again = run_as_other_user(read_only_package, temporary, "-m", "spiraltrunk", *shape)
        assert again.stdout == first.stdout
        assert "compiling" not in again.stderr
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


@pytest.mark.slow
def test_without_any_folder_every_process_compiles(read_only_package: Path) -> None:
    folder = Path(tempfile.mkdtemp())
    try:
        (folder / "kernel.py").write_text(f"""
import tempfile
tempfile.tempdir = {str(folder)!r}
from spiraltrunk.cli import main
main(["--version"])
{KERNEL}""")
        folder.chmod(0o555)
        done = run_as_other_user(read_only_package, folder, str(folder / "kernel.py"))
        assert done.returncode == 0, done.stderr
        assert done.stdout.splitlines()[-1] == "8.0"
        assert "every process compiles the models" in done.stderr
        assert done.stderr.count("NUMBA_CACHE_DIR") == 1
    finally:
        folder.chmod(0o755)
        shutil.rmtree(folder)


def run_kernel(folder: Path, script: str, cache: Path) -> subprocess.CompletedProcess[str]:
    (folder / "kernel.py").write_text(script)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, str(folder / "kernel.py")]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("suffix", "damage"), [pytest.param("nbi", b"\x80random bytes", marks=pytest.mark.slow), ("nbc", b"")]
)
def test_damaged_cache_is_compiled_again(tmp_path: Path, suffix: str, damage: bytes) -> None:
    cache = tmp_path / "cache"
    assert run_kernel(tmp_path, KERNEL, cache).stdout == "8.0\n"
    damaged = list(cache.rglob(f"*.{suffix}"))
    assert damaged
    for file in damaged:
        file.write_bytes(damage)
    done = run_kernel(tmp_path, KERNEL, cache)
    assert (done.returncode, done.stdout) == (0, "8.0\n"), done.stderr
    assert all(file.read_bytes() != damage for file in damaged), "every process would compile again"


@pytest.mark.slow
def test_code_of_another_stamp_is_not_run(tmp_path: Path) -> None:
    """A process that is killed between writing the index and the code must not leave old code under the new stamp."""
    cache = tmp_path / "cache"
    dies = "import os\nfrom numba.core.caching import IndexDataCacheFile\n"
    dies += "IndexDataCacheFile._save_data = lambda self, name, data: os._exit(3)\n"
    lines = "\n" * dies.count("\n")  # A function is kept by its file and line.
    changed = KERNEL.replace("STAMP", "b" * 64).replace("2.0 * x", "3.0 * x")
    assert run_kernel(tmp_path, lines + KERNEL.replace("STAMP", "a" * 64), cache).stdout == "8.0\n"
    assert run_kernel(tmp_path, dies + changed, cache).returncode == 3
    assert run_kernel(tmp_path, lines + changed, cache).stdout == "12.0\n"


@pytest.mark.parametrize("kind", ["open to others", "link", "file"])
def test_temporary_folder_of_somebody_else_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    folder = tmp_path / f"spiraltrunk-kernels-{os.getuid()}"
    if kind == "open to others":
        folder.mkdir()
        folder.chmod(0o777)
    elif kind == "link":
        (tmp_path / "target").mkdir(mode=0o700)
        folder.symlink_to(tmp_path / "target")
    else:
        folder.write_bytes(b"")
    assert kernel_cache._TemporaryFolder.from_function(run_kernel, __file__) is None


def test_own_temporary_folder_is_closed_to_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert kernel_cache._TemporaryFolder.from_function(run_kernel, __file__) is not None
    assert [path.stat().st_mode & 0o777 for path in tmp_path.iterdir()] == [0o700]
