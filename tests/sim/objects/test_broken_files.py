"""Files that are broken at random are an object or one line of error."""

import numpy as np
import pytest
import trimesh

from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.sim.objects.catalogue import parse_object


def break_mesh(mesh, rng):
    """Lose, turn, double, tear, displace and add triangles."""
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    faces = faces[rng.random(len(faces)) > rng.choice([0.0, 0.02, 0.3])]
    turned = rng.random(len(faces)) < rng.choice([0.0, 0.05, 1.0])
    faces[turned] = faces[turned][:, ::-1]
    faces = np.vstack([faces, faces[rng.random(len(faces)) < rng.choice([0.0, 0.5])]])
    if rng.random() < 0.3:
        faces = np.vstack([faces, rng.integers(len(vertices), size=(10, 3))])
    if rng.random() < 0.3:
        vertices = vertices[faces].reshape(-1, 3) + rng.normal(size=(3 * len(faces), 3)) * rng.choice([1e-5, 0.1])
        faces = np.arange(len(vertices)).reshape(-1, 3)
    if rng.random() < 0.2:
        vertices[rng.integers(len(vertices))] = rng.choice([np.nan, np.inf, 1e30, 0.0])
    if rng.random() < 0.2:
        vertices[:, rng.integers(3)] *= rng.choice([0.0, 1e-4, -1.0])
    return trimesh.Trimesh(vertices, faces, process=False)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("form", ["stl", "obj"])
@pytest.mark.parametrize("seed", [*range(8), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(8, 12))])
def test_a_broken_file_is_an_object_or_one_line_of_error(tmp_path, seed, form):
    rng = np.random.default_rng(seed)
    whole = trimesh.creation.cylinder(25, 80, sections=24) if seed % 2 else trimesh.creation.icosphere(2, 30)
    file = tmp_path / f"broken.{form}"
    with np.errstate(all="ignore"):
        break_mesh(whole, rng).export(file)
    content = bytearray(file.read_bytes())
    for place in rng.integers(len(content), size=rng.choice([0, 0, 5])):
        content[place] = rng.integers(256)
    file.write_bytes(content)
    said, shape = "", None
    try:
        shape = parse_object(f"{form}:path={file},mass_g=100")
    except SpiralTrunkError as error:
        said = str(error)
    assert "\n" not in said
    assert len(said) < 420
    if shape is not None:
        assert np.isfinite([*shape.size, *shape.inertia().ravel()]).all()
        assert np.linalg.eigvalsh(shape.inertia()).min() > 0
