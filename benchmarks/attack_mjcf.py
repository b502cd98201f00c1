"""Mutated MJCF: each one gives a model or one line of `DesignError`, within the limits, and reads nothing outside.

Claim: whatever an MJCF of a stranger holds, reading it ends (docs/reference/objects.md, limits of files). Two small
models with includes, meshes and a picture are changed at random by the attacks of `ATTACKS`, one to three a try. Every
try must end in time with a model or with one line of at most 400 characters, leave no process, and never open the file
that lies outside the model's folder. A try that does otherwise is written to a file with its number and ends the run.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import socket
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from PIL import Image

from spiraltrunk.errors import DesignError
from spiraltrunk.sim.mujoco_log import compile_spec
from spiraltrunk.sim.user_files.compile_check import SECONDS_MOST, load_mjcf_spec

SLOWEST = 2.5 * SECONDS_MOST
"""Time that a try may take [s]: the limit of the process, and as long again for the model."""

LONGEST = 400
"""Longest error [characters]."""

TETRAHEDRON = "v 0 0 0\nv .05 0 0\nv 0 .05 0\nv 0 0 .05\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

OBJECT = """
<mujoco model="cup">
  <compiler meshdir="parts" texturedir="parts"/>
  <size memory="1M" nkey="1"/>
  <include file="assets.xml"/>
  <worldbody>
    <geom type="plane" size="1 1 .1"/>
    <body name="cup" pos="0 0 1">
      <freejoint/>
      <geom type="mesh" mesh="block" material="paint"/>
      <replicate count="3" euler="0 0 .3"><geom type="box" size=".02 .03 .01" pos=".05 0 0"/></replicate>
      <body pos="0 .05 0"><geom type="capsule" size=".01 .03" mass=".05"/></body>
    </body>
  </worldbody>
</mujoco>
"""

ARM = """
<mujoco model="arm">
  <compiler angle="radian"/>
  <include file="assets.xml"/>
  <default><joint damping="1" armature=".1"/></default>
  <worldbody>
    <body name="link1"><joint name="j1" axis="0 0 1" range="-2 2"/><geom type="cylinder" size=".05 .2"/>
      <body name="link2" pos="0 0 .4"><joint name="j2" axis="0 1 0" range="-2 2"/>
        <inertial pos="0 0 .1" mass="2" diaginertia=".01 .01 .01"/><geom size=".05" type="sphere"/>
        <site name="tool" pos="0 0 .2"/></body></body>
  </worldbody>
  <actuator><position joint="j1" kp="100"/><position joint="j2" kp="100"/></actuator>
  <sensor><jointpos joint="j1"/></sensor>
  <keyframe><key qpos="0 0"/></keyframe>
</mujoco>
"""

ASSETS = """
<mujoco><asset>
  <mesh file="block.obj"/><texture name="t" type="2d" file="paint.png"/><material name="paint" texture="t"/>
  <texture name="sky" type="skybox" builtin="gradient" width="64" height="64"/>
  <hfield name="hill" nrow="8" ncol="8" size="1 1 1 1"/>
</asset></mujoco>
"""

NUMBERS = (
    "nan",
    "inf",
    "-1",
    "0",
    "1e308",
    "1e999",
    "1e-308",
    "-1e30",
    "1000000000",
    "9" * 400,
    "",
    "a",
    "1 2 3",
    "1e6",
)
"""What a number becomes."""

PATHS = ("../canary.xml", "{canary}", "pipe", "link", "linked/canary.xml", "server", "/dev/zero", "/dev/stdin", ".",
         "parts", "model.xml", "assets.xml", "./assets.xml", "none.xml", "", "a" * 5000, "a\tb",
         "parts/../../canary.xml", "parts/block.obj", "paint.png", "~/a", "%2e%2e/canary.xml",
         "..\\canary.xml")  # fmt: skip
"""What the name of a file becomes."""

COUNTS = ("nkey", "nuserdata", "nuser_geom", "memory", "nstack", "njmax", "nconmax", "nsample", "count", "width",
          "height", "nrow", "ncol", "dim", "num", "resolution", "size", "maxhullvert", "params", "user", "group",
          "gridsize")  # fmt: skip
"""Attributes that are set to many."""

ELEMENTS = (
    "<flexcomp name='f' type='grid' count='200 200 200' spacing='.1 .1 .1'/>",
    "<composite type='cable' count='9999 1 1'/>",
    "<replicate count='100000000'><geom size='.1'/></replicate>", "<plugin plugin='mujoco.sdf.torus'/>",
    "<skin file='pipe'/>",
    "<attach model='m' prefix='p'/>", "<model name='m' file='model.xml'/>", "<include file='pipe'/>",
    "<include file='assets.xml'/>", "<texture name='u' builtin='flat' width='50000'/>", "<numeric size='1000000000'/>",
    "<hfield name='h' nrow='50000' ncol='50000' size='1 1 1 1'/>", "<mesh name='s' builtin='sphere' params='4'/>",
    "<mesh name='v' builtin='supersphere' params='900 1 1'/>", "<user dim='1000000000'/>", "<size nkey='1000000000'/>",
    "<compiler><lengthrange inttotal='100' timestep='1e-9'/></compiler>", "<muscle joint='j1'/>", "<freejoint/>",
    "<extension><plugin plugin='x'/></extension>", "<compiler meshdir='../'/>", "<compiler strippath='true'/>",
    "<camera name='c' resolution='100000 100000'/>", "<frame euler='0 0 1'><geom size='.1'/></frame>",
)  # fmt: skip
"""Elements that are put in."""

MARKUP = (b"<!DOCTYPE mujoco [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]>", b"<!ENTITY x SYSTEM 'file:///etc/passwd'>",
          b"&a;", b"\0", b"<![CDATA[", b"]]>", b"<!--", b"<?xml version='1.0' encoding='utf-16'?>", b"\xff\xfe",
          b"&#0;", b"</body>", b"<a>" * 300, b"xmlns:x='y' ", b"<x:body/>", b"'", b'"')  # fmt: skip
"""Bytes that are put in."""


def choose(root: Element, draw: random.Random) -> Element:
    """An element of the document."""
    return draw.choice(list(root.iter()))


def change_number(root: Element, draw: random.Random) -> None:
    """An attribute becomes another number."""
    element = choose(root, draw)
    if element.attrib:
        element.set(draw.choice(list(element.attrib)), draw.choice(NUMBERS))


def change_path(root: Element, draw: random.Random) -> None:
    """A file gets another name."""
    named = [element for element in root.iter() if element.get("file")]
    (draw.choice(named) if named else choose(root, draw)).set("file", draw.choice(PATHS))


def set_count(root: Element, draw: random.Random) -> None:
    """An attribute that counts is set to many."""
    choose(root, draw).set(
        draw.choice(COUNTS), draw.choice(("1000000000", "99999", "5000", "1000G", "-5", "1e300", "3"))
    )


def put_element(root: Element, draw: random.Random) -> None:
    """An element is put in."""
    choose(root, draw).append(ElementTree.fromstring(draw.choice(ELEMENTS)))


def repeat(root: Element, draw: random.Random) -> None:
    """An element's children are repeated."""
    element = choose(root, draw)
    children = list(element)[: draw.choice((1, 3))]
    element.extend(children * draw.choice((2, 50, 2000)) if len(list(root.iter())) < 3000 else [])


def nest(root: Element, draw: random.Random) -> None:
    """An element is wrapped in many."""
    element, tag = choose(root, draw), draw.choice(("body", "replicate", "frame", "default", "a"))
    for _ in range(draw.choice((3, 60, 300))):
        wrapper = Element(tag, {"count": draw.choice(("2", "1000"))} if tag == "replicate" else {})
        wrapper.extend(list(element))
        element[:] = [wrapper]


def swap(root: Element, draw: random.Random) -> None:
    """An element's children, or its name, become those of another."""
    one, other = choose(root, draw), choose(root, draw)
    if draw.random() < 0.5:
        one.tag = other.tag
    elif root not in (one, other):
        one[:] = [child for child in other if one not in set(child.iter())]


def write_mesh(content: bytes, draw: random.Random) -> bytes:
    """Bytes of a mesh or a picture, changed."""
    data = bytearray(content)
    for _ in range(draw.randint(1, 8)):
        at = draw.randrange(len(data))
        data[at : at + draw.randint(0, 4)] = draw.choice(
            (b"nan", b"1e38", b"-", b"999999999", bytes([draw.randrange(256)]))
        )
    return bytes(data)


TREE: dict[str, Callable[[Element, random.Random], None]] = {
    "number": change_number, "path": change_path, "count": set_count, "element": put_element, "repeat": repeat,
    "nest": nest, "swap": swap,
}  # fmt: skip

ATTACKS = (*TREE, "bytes", "files")
"""Kinds of attack: seven on the document, one on its bytes, one on the files that it names."""


def lay_out(folder: Path) -> Path:
    """Write the files round the model: the ones it may name, a pipe, links out and a server; return the one outside."""
    (folder / "parts").mkdir(parents=True)
    canary = folder.parent / "canary.xml"
    canary.write_text("<mujoco/>")
    os.mkfifo(folder / "pipe")
    (folder / "link").symlink_to(canary)
    (folder / "linked").symlink_to(folder.parent)
    server = socket.socket(socket.AF_UNIX)
    server.bind(os.path.relpath(folder / "server"))
    server.close()
    return canary


def write_try(folder: Path, canary: Path, draw: random.Random) -> list[str]:
    """Write one try and return its attacks."""
    kinds = draw.sample(ATTACKS, draw.choice((1, 1, 2, 3)))
    root = ElementTree.fromstring(draw.choice((OBJECT, ARM)))
    assets = ElementTree.fromstring(ASSETS)
    for kind in kinds:
        if kind in TREE:
            TREE[kind](draw.choice((root, root, assets)), draw)
    data = ElementTree.tostring(root, encoding="unicode").replace("{canary}", str(canary)).encode()
    if "bytes" in kinds:
        at = draw.randrange(len(data))
        data = data[:at] + draw.choice(MARKUP) + data[at + draw.randint(0, 30) :]
    mesh = TETRAHEDRON.encode()
    for place in (folder, folder / "parts"):
        (place / "block.obj").write_bytes(write_mesh(mesh, draw) if "files" in kinds else mesh)
        Image.fromarray(np.zeros((8, 8, 3), np.uint8)).save(place / "paint.png")
        if "files" in kinds:
            (place / "paint.png").write_bytes(write_mesh((place / "paint.png").read_bytes(), draw))
    (folder / "assets.xml").write_bytes(ElementTree.tostring(assets))
    (folder / "model.xml").write_bytes(data)
    return kinds


def outcome(folder: Path) -> str:
    """What came of reading the model: compiled, or by whom it was refused.

    Raises:
        AssertionError: where the error is not one line.
    """
    path = folder / "model.xml"
    try:
        compile_spec(load_mjcf_spec(path.read_bytes(), path, "the file 'model.xml'"))
    except DesignError as error:
        said = str(error)
        if "\n" in said or len(said) > LONGEST:
            raise AssertionError(f"the error is not one line of at most {LONGEST} characters: {said}") from error
        for sign, by in (("too slow", "time"), ("ended with code", "process"), ("MuJoCo loads", "MuJoCo")):
            if sign in said:
                return f"refused by {by}"
        return "refused by the reader"
    return "compiled"


def count_children() -> int:
    """Processes that this one has."""
    return len(Path(f"/proc/self/task/{os.getpid()}/children").read_text().split())


def run(count: int, seconds: float, seed: int) -> dict[str, object]:
    """Read mutated models until there are so many or the time is over.

    Raises:
        AssertionError: with the number of the try, for one that breaks a promise of this module.
    """
    draw, opened = random.Random(seed), []
    tries, attacks, outcomes, slowest = 0, Counter[str](), Counter[str](), 0.0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "model"
        canary = lay_out(folder)
        # Hooks stay for the life of a process.
        sys.addaudithook(lambda event, what: opened.append(what[0]) if event == "open" else None)
        began = time.perf_counter()
        while tries < count and time.perf_counter() - began < seconds:
            kinds = write_try(folder, canary, draw)
            opened.clear()
            start = time.perf_counter()
            try:
                outcomes[outcome(folder)] += 1
                spent = time.perf_counter() - start
                outside = [name for name in opened if Path(os.fsdecode(str(name))).name in {"canary.xml", "pipe"}]
                if outside or count_children() or spent > SLOWEST:
                    raise AssertionError(f"opened {outside}, {count_children()} processes left, {spent:.1f} s")
            except BaseException:
                Path("attack_mjcf_failure.xml").write_bytes((folder / "model.xml").read_bytes())
                print(f"try {tries} of seed {seed}, {kinds}: attack_mjcf_failure.xml", file=sys.stderr)
                raise
            attacks.update(kinds)
            slowest = max(slowest, spent)
            tries += 1
    memory = [resource.getrusage(who).ru_maxrss // 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return {
        "tries": tries, "attacks": dict(attacks), "outcomes": dict(outcomes), "slowest_s": round(slowest, 2),
        "seconds": round(time.perf_counter() - began), "memory_mb": memory[0], "memory_of_processes_mb": memory[1],
    }  # fmt: skip


def main() -> int:
    """Run and print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=3000, help="tries (default 3000)")
    parser.add_argument("--seconds", type=float, default=1e9, help="time after which it ends (default: none)")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    print(json.dumps(run(arguments.count, arguments.seconds, arguments.seed), indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
