"""Counts and numbers of an MJCF document, refused before MuJoCo reserves memory or time for them."""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element

from spiraltrunk.errors import describe
from spiraltrunk.sim.user_files.regular_file import refusal

ELEMENTS_MOST = 5000
"""Largest number of elements, those in a ``replicate`` counted as often as it repeats them (ours)."""

DEPTH_MOST = 100
"""Largest depth of nested elements (ours; MuJoCo's parser stops at 500)."""

TEXELS_MOST = 1 << 25
"""Largest number of pixels of all textures and height fields together (ours)."""

MEMORY_MOST = 1 << 30
"""Largest memory that a file may reserve for simulation data [bytes] (ours)."""

UNSUPPORTED = {
    "attach": "include", "model": "include", "plugin": "no plugins", "extension": "no plugins",
    "flexcomp": "rigid bodies", "composite": "rigid bodies", "deformable": "rigid bodies", "skin": "rigid bodies",
}  # fmt: skip
"""Elements that are refused, and what is allowed in their place."""

_MOST = {
    "nkey": 1000, "nuserdata": 10_000, "nuser_actuator": 100, "nuser_body": 100, "nuser_cam": 100, "nuser_geom": 100,
    "nuser_jnt": 100, "nuser_sensor": 100, "nuser_site": 100, "nuser_tendon": 100, "nconmax": 100_000,
    "njmax": 1_000_000, "nstack": 100_000_000, "nsample": 10_000, "dim": 10_000, "num": 1000, "resolution": 8192,
    "params": 1000, "offwidth": 8192, "offheight": 8192, "shadowsize": 16_384, "offsamples": 64, "numslices": 1000,
    "numstacks": 1000, "numquads": 1000, "sdf_initpoints": 10_000, "sdf_iterations": 1000, "actdim": 1000,
    "maxhullvert": 100_000, "inttotal": 100, "gridsize": 100,
}  # fmt: skip
"""Largest values of attributes that count (ours)."""

_MANY = 10**15
"""More than any limit; counts are not counted beyond."""

_SUFFIXES = {"k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40, "p": 1 << 50, "e": 1 << 60}


def check_counts(root: Element, what: str, texels: int = 0) -> None:
    """Refuse counts above the limits, numbers that are not finite and elements that are not supported.

    Args:
        root: the document, its includes resolved.
        what: name of the file in errors.
        texels: pixels of its picture files.

    Raises:
        DesignError: with the number given and the number allowed.
    """
    total, todo = 0, [(root, 1, 1)]
    while todo:
        element, times, depth = todo.pop()
        _check_element(element, what, depth)
        total += times
        times = (
            min(_MANY, times * int(max(1, _first(element.get("count"), 1)))) if element.tag == "replicate" else times
        )
        todo += [(child, times, depth + 1) for child in element]
        texels += _texels(element)
    if total > ELEMENTS_MOST:
        raise refusal(what, f"of {total} elements, repeated ones included", f"at most {ELEMENTS_MOST}")
    if texels > TEXELS_MOST:
        raise refusal(what, f"of textures and height fields of {texels} pixels", f"at most {TEXELS_MOST}")


def _check_element(element: Element, what: str, depth: int) -> None:
    if element.tag in UNSUPPORTED:
        raise refusal(what, f"one with <{element.tag}>", UNSUPPORTED[element.tag])
    if depth > DEPTH_MOST:
        raise refusal(what, f"of more than {DEPTH_MOST} nested elements", f"at most {DEPTH_MOST}")
    for name, text in element.items():
        numbers = _numbers(text)
        if not all(map(math.isfinite, numbers)):
            raise refusal(what, f"one with {name}={describe(text, 30)} in <{element.tag}>", "finite numbers")
        most = ELEMENTS_MOST if (element.tag, name) == ("numeric", "size") else _MOST.get(name, math.inf)
        if numbers and max(numbers) > most:
            raise refusal(what, f"one with {name}={describe(text, 30)} in <{element.tag}>", f"at most {most}")
        if name == "memory" and _bytes(text) > MEMORY_MOST:
            raise refusal(what, f"one with memory={describe(text, 30)}", f"at most {MEMORY_MOST >> 20}M")


def _texels(element: Element) -> int:
    """Pixels of a built-in texture or a height field; a texture that is not 2d is a cube of six squares."""
    if element.tag == "hfield":
        return int(min(_MANY, max(0.0, _first(element.get("nrow"), 0) * _first(element.get("ncol"), 0))))
    if element.tag != "texture":
        return 0
    width, height = (max(0.0, _first(element.get(side), 0)) for side in ("width", "height"))
    return int(min(_MANY, width * (height if element.get("type") == "2d" else 6 * width)))


def _numbers(text: str) -> list[float]:
    """The numbers of an attribute; none of a text."""
    try:
        return [float(token) for token in text.split()]
    except ValueError:
        return []


def _first(text: str | None, default: float) -> float:
    numbers = _numbers(text or "")
    return numbers[0] if numbers and math.isfinite(numbers[0]) else default


def _bytes(text: str) -> float:
    """Size of memory in MuJoCo's notation, such as 3M [bytes]."""
    text = text.strip().lower()
    return _first(text.rstrip("kmgtpe"), 0) * _SUFFIXES.get(text[-1:], 1)
