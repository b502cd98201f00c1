"""The house's import rules hold, and a breach of each is noticed."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[2]

HEAVY = ("mujoco", "mink", "daqp", "qpsolvers", "matplotlib", "av", "PIL", "rich", "gymnasium", "build123d", "OCP")
"""Packages that cost time or a display, loaded only by the layer that uses them."""

LIGHT = {"spiraltrunk", "numpy", "scipy", "numba", *sys.stdlib_module_names}
"""All that design and model may import."""

BREACHES = {
    "design above model": ("design/spiral.py", "from spiraltrunk.model import cables", "layers"),
    "errors above design": ("errors.py", "import spiraltrunk.design.spiral", "layers"),
    "checks above files": ("checks.py", "import spiraltrunk.files.atomic", "layers"),
    "model above control": ("model/kinematics/shape.py", "import spiraltrunk.control.messages", "layers"),
    "control above sim": ("control/plant.py", "import spiraltrunk.sim.breach", "layers"),
    "sim beside report": ("sim/breach.py", "import spiraltrunk.report.breach", "layers"),
    "sim beside strategies": ("sim/breach.py", "import spiraltrunk.strategies.breach", "layers"),
    "calibration beside mocap": ("calibration/calibrate.py", "import spiraltrunk.mocap.recordings.take", "layers"),
    "mocap beside report": ("mocap/recordings/take.py", "import spiraltrunk.report.breach", "layers"),
    "report above workflows": ("report/breach.py", "import spiraltrunk.workflows.grasp.trial", "layers"),
    "hidden in a function": ("design/spiral.py", "def f() -> None:\n    import spiraltrunk.model", "layers"),
    "a folder that is no layer": ("utils/__init__.py", "", "layers"),
    "grasp above survey": ("workflows/grasp/trial.py", "import spiraltrunk.workflows.export.export", "workflows"),
    "survey beside validate": (
        "workflows/survey/plan.py",
        "import spiraltrunk.workflows.validate.page",
        "workflows",
    ),
    "a circle of two modules": ("cad/geometry/csg.py", "import spiraltrunk.cad.geometry.occ", "circles"),
    "a circle of two folders": ("model/kinematics/shape.py", "import spiraltrunk.model.statics.loads", "circles"),
    "mujoco in strategies": ("strategies/breach.py", "import mujoco", "dynamics"),
    "mink in the command line": ("cli/verbs/grasp.py", "import mink", "dynamics"),
    "mujoco in report": ("report/breach.py", "import mujoco", "dynamics"),
    "matplotlib in sim": ("sim/breach.py", "import matplotlib.pyplot as plt", "pictures"),
    "matplotlib in the loop": ("control/loop.py", "import matplotlib", "pictures"),
    "build123d in the export": ("workflows/export/export.py", "import build123d", "solids"),
    "viser in workflows": ("workflows/grasp/trial.py", "import viser", "page"),
    "studio below the command line": ("report/breach.py", "import spiraltrunk.studio.tabs", "layers"),
    "OCP in sim": ("sim/breach.py", "from OCP.gp import gp_Pnt", "solids"),
    "cad beside sim": ("cad/__init__.py", "import spiraltrunk.sim.breach", "layers"),
    "rich in design": ("design/spiral.py", "import rich", "light"),
    "av in model": ("model/kinematics/cables.py", "import av", "light"),
}
"""A file, the line put at its end, and the contract that forbids it."""

CONTRACTS = {
    "layers": "Imports run downwards only",
    "circles": "No import circle, in no folder",
    "workflows": "Workflows build on a grasp, and else stand alone",
    "dynamics": "MuJoCo and mink stay in sim and envs",
    "pictures": "matplotlib stays in report",
    "page": "viser stays in studio",
    "solids": "build123d stays in cad",
    "light": "design and model need NumPy, SciPy and Numba alone",
}


def lint_imports(folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()", "--no-cache"]
    environment = {**os.environ, "PYTHONPATH": str(folder / "src"), "COLUMNS": "200", "PYTHONUTF8": "1"}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, encoding="utf-8", check=False)


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """A copy of the sources with every layer that a breach needs."""
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    package = tmp_path / "src" / "spiraltrunk"
    shutil.copytree(ROOT / "src" / "spiraltrunk", package, ignore=shutil.ignore_patterns("__pycache__"))
    for layer in ("sim", "report", "strategies"):
        (package / layer).mkdir(exist_ok=True)
        for name in ("__init__.py", "breach.py"):
            (package / layer / name).touch()
    return tmp_path


def test_house_keeps_its_contracts() -> None:
    lint = lint_imports(ROOT)
    assert lint.returncode == 0, lint.stdout + lint.stderr
    for name in CONTRACTS.values():
        assert f"{name} KEPT" in lint.stdout


FAST = {"design above model", "matplotlib in sim", "a circle of two modules"}
"""A breach of each kind of contract."""


@pytest.mark.parametrize(
    "breach",
    [pytest.param(breach, marks=[] if breach in FAST else [pytest.mark.slow]) for breach in BREACHES],
)
def test_breach_is_noticed(house: Path, breach: str) -> None:
    file, line, contract = BREACHES[breach]
    path = house / "src" / "spiraltrunk" / file
    path.parent.mkdir(exist_ok=True)
    with path.open("a") as source:
        source.write(f"\n{line}\n")
    lint = lint_imports(house)
    assert lint.returncode == 1, lint.stdout + lint.stderr
    assert f"{CONTRACTS[contract]} BROKEN" in lint.stdout
    broken = {key for key, name in CONTRACTS.items() if f"{name} BROKEN" in lint.stdout}
    assert broken <= {contract, "circles"}  # An import upwards often closes a circle too.


def test_design_and_model_import_nothing_else() -> None:
    graph = grimp.build_graph("spiraltrunk", include_external_packages=True, cache_dir=None)
    strangers = [
        f"{module} imports {imported}"
        for module in sorted(graph.modules)
        if module.startswith(
            ("spiraltrunk.design", "spiraltrunk.model", "spiraltrunk.errors", "spiraltrunk.control.plant")
        )
        for imported in graph.find_modules_directly_imported_by(module)
        if imported.split(".")[0] not in LIGHT
    ]
    assert strangers == []


@pytest.mark.parametrize(
    "module", ["spiraltrunk", "spiraltrunk.design", "spiraltrunk.model", "spiraltrunk.control.plant", "spiraltrunk.cli"]
)
def test_import_stays_light(module: str) -> None:
    program = f"import sys, {module}; print(*(name for name in {HEAVY!r} if name in sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert loaded.split() == []


PUBLIC = {
    "spiraltrunk.design": ("Spiral", "TrunkDesign", "GripperDesign", "design_from_rules", "graspable_range", "payload",
                           "presets", "load_design", "write_design"),
    "spiraltrunk.model": ("reference", "statics", "inverse", "cables"),
    "spiraltrunk.model.reference": ("rest", "bend_dorsal", "bend_ventral", "twist"),
    "spiraltrunk.model.statics": ("solve", "Loads", "StaticsOptions"),
    "spiraltrunk.model.inverse": ("solve", "follow", "curl"),
    "spiraltrunk.control": ("Plant", "Strategy", "Status", "Milestone", "RunLog", "run"),
    "spiraltrunk.sim": ("SimPlant",),
    "spiraltrunk.strategies": ("get", "NAMES"),
    "spiraltrunk.mocap": ("load_take",),
    "spiraltrunk.workflows.grasp": ("run_trial",),
}  # fmt: skip
"""Names that users import, by the package that they import them from."""


@pytest.mark.parametrize("package", PUBLIC)
def test_public_names_stay_where_users_import_them(package: str) -> None:
    module = importlib.import_module(package)
    assert [name for name in PUBLIC[package] if not hasattr(module, name)] == []
