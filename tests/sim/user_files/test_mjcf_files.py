"""MJCF of a stranger: what it may not name or count is refused in one line, and what is sound works as in MuJoCo."""

import math
import os
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh
from PIL import Image

from spiraltrunk import cli
from spiraltrunk.design import ArmDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.sim import arm_spec
from spiraltrunk.sim.objects.catalogue import load_mjcf, parse_object
from spiraltrunk.sim.user_files import compile_check, limited_process
from spiraltrunk.sim.user_files.compile_check import load_mjcf_spec
from spiraltrunk.sim.user_files.mjcf_counts import DEPTH_MOST, ELEMENTS_MOST

GEOM = "<geom size='.03'/>"


def one_body(inner=GEOM, extra=""):
    return f"<mujoco>{extra}<worldbody><body>{inner}</body></worldbody></mujoco>"


def include(name):
    return f"<mujoco><include file='{name}'/></mujoco>"


def asset(text):
    return one_body(extra=f"<asset>{text}</asset>")


def slow():
    """MuJoCo simulates the muscle's length range at a tiny time step, for hours."""
    muscle = (
        "<actuator><muscle joint='j'/></actuator><compiler><lengthrange inttotal='100' timestep='1e-9'/></compiler>"
    )
    return one_body("<joint name='j' range='-1 1'/>" + GEOM, muscle)


def _fifo(folder):
    os.mkfifo(folder / "fifo.xml")
    return include("fifo.xml")


def _mesh_fifo(folder):
    os.mkfifo(folder / "a.stl")
    return asset("<mesh file='a.stl'/>")


def _socket(folder):
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(os.path.relpath(folder / "socket.xml"))
    return include("socket.xml")


def _linked(target):
    def write(folder):
        (folder.parent / "outside").mkdir(exist_ok=True)
        (folder.parent / "outside" / "secret.xml").write_text("<mujoco/>")
        (folder / "link").symlink_to(target)
        return include("link" if target == "/dev/zero" else "link/secret.xml" if target == "../outside" else "link")

    return write


def _circle(folder):
    (folder / "a.xml").write_text(include("b.xml"))
    (folder / "b.xml").write_text(include("a.xml"))
    return include("a.xml")


def _bomb(_):
    levels = "".join(f"<!ENTITY e{i} '{f'&e{i - 1};' * 10}'>" for i in range(1, 12))
    return f"<!DOCTYPE mujoco [<!ENTITY e0 'lol'>{levels}]><mujoco model='&e11;'/>"


def _picture(folder):
    """A PNG whose header says 60000 x 60000."""
    header = b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sIIBBBBB", 13, b"IHDR", 60_000, 60_000, 8, 2, 0, 0, 0)
    (folder / "a.png").write_bytes(header + bytes(40))
    return asset("<texture type='2d' file='a.png'/>")


def _not_finite(folder):
    content = bytearray(trimesh.creation.box(extents=(0.1, 0.1, 0.1)).export(file_type="stl"))
    content[84 + 12 : 84 + 16] = np.float32(np.nan).tobytes()
    (folder / "a.stl").write_bytes(content)
    return one_body("<geom type='mesh' mesh='a'/>", "<asset><mesh file='a.stl'/></asset>")


def _too_large(folder):
    with (folder / "a.obj").open("wb") as file:
        file.truncate(20_000_001)
    return asset("<mesh file='a.obj'/>")


PARSER = "no MJCF; allowed: well-formed XML; the parser says of 'object.xml': "
FLEXIBLE = "<flexcomp name='f' type='grid' count='200 200 200' spacing='1 1 1'/>"
OUTSIDE = "regular files of 1 byte to 20 MB in its own folder or below"
INERTIAL = "<inertial pos='{pos}' mass='.1' diaginertia='{i} {i} {i}'/>" + GEOM

REFUSED = {
    "fifo": (_fifo, OUTSIDE),
    "fifo of a mesh": (_mesh_fifo, OUTSIDE),
    "socket": (_socket, OUTSIDE),
    "device": (_linked("/dev/zero"), OUTSIDE),
    "linked file": (_linked("../outside/secret.xml"), OUTSIDE),
    "linked folder": (_linked("../outside"), OUTSIDE),
    "folder": (lambda folder: include("."), OUTSIDE),
    "absolute": (lambda folder: include(folder / "object.xml"), OUTSIDE),
    "above": (lambda folder: include(f"../{folder.name}/../none.xml"), OUTSIDE),
    "null byte": (lambda folder: include("a&#0;b"), PARSER + "reference to invalid character number"),
    "missing": (lambda folder: include("none.xml"), "names 'none.xml', which does not exist"),
    "too large": (_too_large, OUTSIDE),
    "circle": (_circle, "includes 'a.xml' twice or in a circle; allowed: each file once"),
    "itself": (lambda folder: include("object.xml"), "includes 'object.xml' twice or in a circle"),
    "entities": (_bomb, "one with a document type; allowed: XML without <!DOCTYPE>"),
    "depth": (lambda folder: "<mujoco>" + "<a>" * 500_000, f"more than {DEPTH_MOST} nested elements"),
    "replicates": (lambda folder: one_body(f"<replicate count='100000000'>{GEOM}</replicate>"),
                   f"of 100000004 elements, repeated ones included; allowed: at most {ELEMENTS_MOST}"),
    "nested replicates": (lambda folder: one_body("<replicate count='1e308'>" * 90 + GEOM + "</replicate>" * 90),
                          "repeated ones included"),
    "keys": (lambda folder: one_body(extra="<size nkey='1000000000'/>"), "nkey='1000000000'.*allowed: at most 1000"),
    "huge number": (lambda folder: one_body(extra=f"<size nkey='{'9' * 5000}'/>"), "nkey='999.*999'.*allowed: finite"),
    "flexible": (lambda folder: one_body(FLEXIBLE).replace("<body>", "<body name='b'>"),
                 "one with <flexcomp>; allowed: rigid bodies"),
    "geoms": (lambda folder: one_body(GEOM * 100_000), f"more than {ELEMENTS_MOST} elements"),
    "memory": (lambda folder: one_body(extra="<size memory='1000G'/>"), "memory='1000G'; allowed: at most 1024M"),
    "custom": (lambda folder: one_body(extra="<custom><numeric name='n' size='1000000000' data='1'/></custom>"),
               "size='1000000000' in <numeric>"),
    "texture": (lambda folder: asset("<texture type='2d' builtin='flat' width='100000' height='100000'/>"), "pixels"),
    "cube texture": (lambda folder: asset("<texture type='skybox' builtin='flat' width='9000'/>"), "pixels"),
    "picture": (_picture, "of 3600000000 pixels"),
    "height field": (lambda folder: asset("<hfield name='h' nrow='60000' ncol='60000' size='1 1 1 1'/>"), "pixels"),
    "plugin": (lambda folder: one_body(extra="<extension><plugin plugin='x'/></extension>"), "no plugins"),
    "attached": (lambda folder: asset("<model file='object.xml' name='m'/>"), "one with <model>; allowed: include"),
    "not a number": (lambda folder: one_body("<geom size='.03' pos='0 nan 0'/>"), "pos='0 nan 0'.*finite numbers"),
    "infinite": (lambda folder: one_body("<geom size='.03' density='1e999'/>"), "density='1e999'.*finite numbers"),
    "mesh": (_not_finite, "no MJCF that MuJoCo loads|not finite"),
    "mass far away": (lambda folder: one_body(INERTIAL.format(pos="1e6 0 0", i="1e-4")), "1e.06 m"),
    "inertia": (lambda folder: one_body(INERTIAL.format(pos="0 0 0", i="1e6")), "radius of gyration"),
    "cut": (lambda folder: "<mujoco><worldbody>", PARSER + "no element found: line 1, column 19"),
    "binary": (lambda folder: "\x00\x01", PARSER + "not well-formed .invalid token.: line 1, column 0"),
    "urdf": (lambda folder: "<robot name='r'/>", "root 'robot'; allowed: <mujoco>"),
}  # fmt: skip
"""What a file holds, and what is said of it."""

HANGS = ("fifo", "replicates", "keys", "flexible", "geoms")
"""Those at which MuJoCo itself hung, or took half a minute."""


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / "model"
    place.mkdir()
    return place


@pytest.fixture
def put(folder):
    def write(text):
        (folder / "object.xml").write_text(text)
        return str(folder / "object.xml")

    return write


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_file_may_not_hold_is_refused_in_one_line(put, folder, name):
    build, match = REFUSED[name]
    path = put(build(folder))
    with pytest.raises(DesignError, match=match) as caught:
        load_mjcf(path)
    said = str(caught.value)
    assert said.startswith("the file 'object.xml' is ")
    assert "\n" not in said
    assert len(said) < 350


@pytest.mark.parametrize("name", HANGS)
def test_a_hang_is_bad_input_of_the_command_line(put, folder, name, capsys):
    path = put(REFUSED[name][0](folder))
    assert cli.main(["grasp", "--object", f"mjcf:path={path}", "--no-video"]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("spiraltrunk: error: the file 'object.xml' is ")
    assert printed.err.count("\n") == 1


@pytest.mark.parametrize("name", HANGS)
def test_an_arm_is_read_by_the_same_rules(put, folder, name):
    path = put(REFUSED[name][0](folder))
    with pytest.raises(DesignError, match=r"^arm\.model 'object.xml' is .*" + REFUSED[name][1]):
        arm_spec(ArmDesign(model=path, mount_site="tool"))


@pytest.mark.parametrize(
    ("inner", "match"),
    [
        ("<inertial pos='1e6 0 0' mass='1' diaginertia='1 1 1'/>", r"a position of 1e\+06 m; allowed: at most 10 m"),
        ("<inertial pos='0 0 0' mass='1e6' diaginertia='1 1 1'/>", r"a mass of 1e\+06 kg; allowed: at most 1000 kg"),
        ("<inertial pos='0 0 0' mass='1' diaginertia='1e6 1e6 1e6'/>", r"an inertia of 1e\+06 kg m\^2"),
    ],
)  # fmt: skip
def test_an_arm_of_absurd_numbers_is_refused(put, inner, match):
    path = put(one_body(inner + "<joint/><site name='tool'/>" + GEOM))
    with pytest.raises(DesignError, match=match):
        arm_spec(ArmDesign(model=path, mount_site="tool"))


# The process.


@pytest.fixture
def started(monkeypatch):
    """Processes that were started."""
    found, start = [], subprocess.Popen

    def note(*arguments, **options):
        found.append(start(*arguments, **options))
        return found[-1]

    monkeypatch.setattr(subprocess, "Popen", note)
    monkeypatch.setattr(compile_check, "_compiled", set())
    return found


def test_a_file_that_compiles_too_slowly_is_refused_and_its_process_is_gone(put, started, monkeypatch):
    monkeypatch.setattr(compile_check, "SECONDS_MOST", 3)
    with pytest.raises(DesignError, match=r"is too slow to compile; allowed: at most 3 s|ended with code -"):
        load_mjcf(put(slow()))
    (child,) = started
    assert child.returncode in {-signal.SIGKILL, -signal.SIGXCPU}
    assert not Path(f"/proc/{child.pid}").exists()


def test_a_file_that_takes_too_much_memory_is_refused(put, monkeypatch):
    monkeypatch.setattr(limited_process, "MEMORY_MOST", 800 << 20)
    with pytest.raises(DesignError, match=r"no MJCF that MuJoCo loads; .*allocate|ended with code"):
        load_mjcf(put(one_body(extra="<size memory='1000M'/>")))
    monkeypatch.undo()
    assert load_mjcf(put(one_body())).mass > 0


def test_the_same_content_is_tried_once(put, folder, started):
    load_mjcf(put(one_body()))
    load_mjcf(put(one_body()))
    assert len(started) == 1
    load_mjcf(put(one_body("<geom size='.031'/>")))
    assert len(started) == 2
    assert not any(Path(f"/proc/{child.pid}").exists() for child in started)


def test_objects_by_their_measures_and_described_arms_start_no_process(started):
    parse_object("cone-90")
    arm_spec(ArmDesign())
    assert started == []


READ = "import sys; from spiraltrunk.sim.objects.mjcf import load_mjcf; load_mjcf(sys.argv[1])"


def _children(pid):
    place = Path(f"/proc/{pid}/task/{pid}/children")
    return [int(child) for child in place.read_text().split()] if place.exists() else []


def _wait(condition):
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.mark.parametrize("number", [pytest.param(signal.SIGINT, marks=pytest.mark.slow), signal.SIGKILL])
def test_the_process_ends_with_the_one_that_reads(put, number):
    """Also where that one is killed and can end nothing."""
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)  # Heard also where the tests run in the background.
    try:
        command = [sys.executable, "-c", READ, put(slow())]
        reader = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    finally:
        signal.signal(signal.SIGINT, before)
    _wait(lambda: _children(reader.pid))
    (child,) = _children(reader.pid)
    _wait(lambda: b"limited_child" in Path(f"/proc/{child}/cmdline").read_bytes())
    reader.send_signal(number)
    _, said = reader.communicate(timeout=60)
    assert reader.returncode == -number
    assert ("KeyboardInterrupt" in said) == (number == signal.SIGINT)
    _wait(lambda: not Path(f"/proc/{child}").exists() or "State:\tZ" in Path(f"/proc/{child}/status").read_text())


# What is sound.

TETRAHEDRON = "v 0 0 0\nv .05 0 0\nv 0 .05 0\nv 0 0 .05\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
BODY = "<worldbody><body><geom type='mesh' mesh='o' material='m'/></body></worldbody>"
MATERIAL = "<texture name='t' type='2d' file='{}'/><material name='m' texture='t'/>"
MESH = "<mesh file='{}'/>"

SOUND = {
    "beside": ("", "o.obj", "p.png", ""),
    "below": ("", "parts/o.obj", "parts/p.png", ""),
    "meshdir": ("<compiler meshdir='parts' texturedir='sub'/>", "o.obj", "p.png", ""),
    "assetdir": ("<compiler assetdir='parts'/>", "o.obj", "p.png", ""),
    "both": ("<compiler assetdir='nowhere' meshdir='parts' texturedir='sub'/>", "o.obj", "p.png", ""),
    "the last": ("<compiler meshdir='nowhere'/><compiler assetdir='parts'/>", "o.obj", "p.png", ""),
    "stripped": ("<compiler meshdir='parts' strippath='true'/>", "x/y/o.obj", "C:/p.png", ""),
    "by default": ("", "o.obj", "p.png", "<default><geom density='500'/><mesh scale='2 2 2'/></default>"),
}
"""Compiler, mesh file, texture file and more of a document that MuJoCo reads."""


@pytest.fixture
def parts(folder):
    """A mesh and a picture in the folder, in ``parts`` and in ``sub``, of three sizes."""
    for size, place in enumerate((folder, folder / "parts", folder / "sub"), start=1):
        place.mkdir(exist_ok=True)
        (place / "o.obj").write_text(TETRAHEDRON.replace(".05", f".0{4 + size}"))
        Image.new("RGB", (8 * size, 8), (0, 90, 200)).save(place / "p.png")
    return folder


def _assert_same(path):
    """The model is the one that MuJoCo makes of the file itself."""
    model = load_mjcf_spec(Path(path).read_bytes(), Path(path), "it").compile()
    theirs = mujoco.MjModel.from_xml_path(path)
    for name in ("mesh_vert", "mesh_face", "tex_data", "tex_width", "body_mass", "body_inertia", "geom_size", "names"):
        np.testing.assert_array_equal(getattr(model, name), getattr(theirs, name), err_msg=name)
    return model


WHOLE = [(name, "whole") for name in SOUND]
INCLUDED = [(name, "included") for name in SOUND if name != "the last"]  # MuJoCo looks halfway through an include.
ROWS = WHOLE + INCLUDED
FAST = {(name, "whole") for name in ("below", "both", "the last", "stripped", "by default")} | {("meshdir", "included")}
"""Rows of which each differs from the others in more than a folder."""


@pytest.mark.parametrize(
    ("name", "where"),
    [
        *(row for row in ROWS if row in FAST),
        *(pytest.param(*row, marks=pytest.mark.slow) for row in ROWS if row not in FAST),
    ],
)
def test_files_are_found_where_mujoco_finds_them(parts, put, name, where):
    compiler, mesh, picture, more = SOUND[name]
    assets = f"<asset>{MESH.format(mesh)}{MATERIAL.format(picture)}</asset>"
    (parts / "sub" / "assets.xml").write_text(f"<mujocoinclude>{compiler}{more}{assets}</mujocoinclude>")
    text = "<include file='sub/assets.xml'/>" if where == "included" else compiler + more + assets
    model = _assert_same(put(f"<mujoco>{text}{BODY}</mujoco>"))
    assert model.nmesh == model.ntex == 1


@pytest.mark.parametrize("place", ["../p.png", "../outside/p.png", "missing.png", "/etc/hostname"])
def test_a_texture_that_may_not_be_read_is_left_out(parts, put, place):
    """As in published objects, whose textures lie beside the folder of the objects."""
    (parts.parent / "p.png").write_bytes((parts / "p.png").read_bytes())
    named = f"<texture name='t' type='2d' file='{place}'/><texture type='2d' file='gone.png'/>"
    materials = "<material name='m' texture='t'/><material name='n'><layer texture='t' role='rgb'/></material>"
    text = f"<mujoco><asset>{MESH.format('o.obj')}{named}{materials}</asset>{BODY}</mujoco>"
    path = put(text)
    model = load_mjcf_spec(Path(path).read_bytes(), Path(path), "it").compile()
    assert (model.nmesh, model.ntex, model.nmat) == (1, 0, 2)
    bare = put(f"<mujoco><asset>{MESH.format('o.obj')}<material name='m'/></asset>{BODY}</mujoco>")
    assert load_mjcf(bare).mass == load_mjcf(put(text)).mass > 0


def test_an_include_is_sought_beside_the_main_file_first(folder, put):
    (folder / "sub").mkdir()
    for place, count in ((folder / "inner.xml", 1), (folder / "sub" / "inner.xml", 2)):
        place.write_text(f"<mujoco><worldbody>{GEOM * count}</worldbody></mujoco>")
    (folder / "sub" / "a.xml").write_text(include("inner.xml"))
    path = put(include("sub/a.xml"))
    assert _assert_same(path).ngeom == 1
    (folder / "inner.xml").unlink()
    assert _assert_same(path).ngeom == 2


def test_an_include_keeps_its_place_among_the_elements(folder, put):
    (folder / "more.xml").write_text("<mujoco><geom size='.02'/><geom size='.03'/></mujoco>")
    path = put(one_body("<geom size='.01'/><include file='more.xml'/><geom size='.04'/>"))
    np.testing.assert_allclose(_assert_same(path).geom_size[:, 0], [0.01, 0.02, 0.03, 0.04])


def test_links_within_the_folder_and_a_linked_file_work(parts, put, tmp_path):
    path = put(f"<mujoco><asset>{MESH.format('linked/o.obj')}{MATERIAL.format('p.png')}</asset>{BODY}</mujoco>")
    (parts / "linked").symlink_to("parts")
    link = tmp_path / "entry"
    link.symlink_to(parts)
    assert load_mjcf(str(link / "object.xml")).mass == load_mjcf(path).mass > 0


def test_an_object_of_meshes_and_includes_is_grasped_as_its_file_says(parts, put):
    (parts / "sub" / "assets.xml").write_text(f"<mujoco><asset>{MESH.format('o.obj')}</asset></mujoco>")
    text = "<include file='sub/assets.xml'/>" + BODY.replace(" material='m'", "")
    shape = load_mjcf(put(f"<mujoco>{text}</mujoco>"))
    assert shape.size == pytest.approx((0.05, 0.05, 0.05), rel=1e-6)
    assert shape.mass == pytest.approx(1000 * 0.05**3 / 6, rel=1e-6)
    assert math.isfinite(shape.solid.excess)
