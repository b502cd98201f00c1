"""A scene as MJCF text, for those who store what a trial took place in."""

from __future__ import annotations

import re
from pathlib import PurePath

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.mujoco_log import compile_spec
from spiraltrunk.sim.robot.arm import PREFIX
from spiraltrunk.sim.scene.build import build_spec
from spiraltrunk.sim.scene.options import SceneOptions

_FILE = re.compile(r'(?<=\bfile=")[^"]*')


def format_scene(design: TrunkDesign, options: SceneOptions) -> str:
    """MJCF of the scene.

    The arm's visual meshes are left out where they bear no mass: they are most of the text. Mesh files are named
    without their folders. The tuned softness of the joint limits is not in it: MJCF has no element for it.
    """
    spec = build_spec(design, options)
    for geom in [each for each in spec.geoms if each.meshname.startswith(PREFIX) and each.contype == 0]:
        if geom.parent.explicitinertial:
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in [each for each in spec.meshes if each.name not in used]:
        spec.delete(mesh)
    compile_spec(spec)
    return _FILE.sub(lambda found: PurePath(found[0]).name, spec.to_xml())
