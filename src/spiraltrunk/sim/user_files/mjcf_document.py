"""An MJCF file with everything that it names: read within limits, never by MuJoCo itself.

The document is parsed here, its includes are put in place and its files are read: MuJoCo gets one text and bytes in
memory. A file is found as MuJoCo finds it: an include beside the main file, else beside the file that includes it;
an asset below ``meshdir`` or ``texturedir``, else beside the file that names it (MuJoCo, XML reference, include and
compiler).
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import final
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from spiraltrunk.errors import DesignError, describe
from spiraltrunk.sim.user_files.mjcf_counts import DEPTH_MOST, ELEMENTS_MOST, check_counts
from spiraltrunk.sim.user_files.regular_file import FILE_MOST, read_below, refusal

FILES_MOST = 500
"""Largest number of files that an MJCF names (ours)."""

BYTES_MOST = 200_000_000
"""Largest size of all files together [bytes] (ours)."""

_ALLOWED = f"regular files of 1 byte to {FILE_MOST // 1_000_000} MB in its own folder or below"
_BLOCK = 1 << 16
_PNG = b"\x89PNG\r\n\x1a\n"


@final
@dataclass(frozen=True, kw_only=True)
class MjcfDocument:
    """One MJCF text without includes, and the files that it names."""

    what: str
    """Name of the file in errors."""
    text: str
    """The document."""
    assets: dict[str, bytes]
    """Content of each file, by its name in the document."""

    @cached_property
    def digest(self) -> str:
        """Hash of the document and all files."""
        digest = hashlib.sha256(self.text.encode())
        for name, content in self.assets.items():
            digest.update(f"\0{name}\0{len(content)}\0".encode() + content)
        return digest.hexdigest()


def load_mjcf_document(content: bytes, path: Path, what: str) -> MjcfDocument:
    """The MJCF of that content at that path.

    Args:
        content: what the file holds.
        path: where it lies, for the files that it names.
        what: name of the file in errors.

    Raises:
        DesignError: where it is no XML of limited size and depth, names files that may not be read, or exceeds a limit
            of `check_counts`.
    """
    return _Reader(path, what).read(content)


@final
class _Reader:
    """Reads one file and all that it names."""

    def __init__(self, path: Path, what: str) -> None:
        self._what = what
        self._folder = path.expanduser().absolute().parent
        self._name = path.name
        self._files: dict[str, bytes] = {}
        self._included = {self._name}
        self._homes: dict[Element, Path] = {}
        self._n_element = 0

    def read(self, content: bytes) -> MjcfDocument:
        """The whole document."""
        root = self._parse(content, self._name)
        if root.tag != "mujoco":
            raise self._refuse(f"no MJCF but XML with the root {describe(root.tag, 40)}", "<mujoco>")
        self._splice(root, Path())
        folders = _take_folders(root)
        self._leave_out_textures(root, folders)
        assets = self._take_assets(root, folders)
        check_counts(root, self._what, sum(map(_count_pixels, assets.values())))
        return MjcfDocument(what=self._what, text=ElementTree.tostring(root, encoding="unicode"), assets=assets)

    def _parse(self, content: bytes, name: str) -> Element:
        """Root of one XML text of limited size and depth, without a document type, which could define entities."""
        try:
            text = content.decode("utf-8-sig")
            if "<!DOCTYPE" in text:
                raise self._refuse("one with a document type", f"XML without <!DOCTYPE>; {describe(name)} has one")
            parser = ElementTree.XMLParser(target=_Builder(self._n_element))
            for start in range(0, len(text), _BLOCK):
                parser.feed(text[start : start + _BLOCK])
            root: Element = parser.close()
        except UnicodeDecodeError:
            raise self._refuse("no MJCF", f"XML in UTF-8; {describe(name)} is not") from None
        except ElementTree.ParseError as error:
            raise self._refuse("no MJCF", f"well-formed XML; the parser says of {describe(name)}: {error}") from None
        except _TooMuch as error:
            raise self._refuse(f"one with {error.args[0]}", error.args[1]) from None
        self._n_element += sum(1 for _ in root.iter())
        return root

    def _splice(self, root: Element, home: Path) -> None:
        """Put the children of every included file in the place of its include; ``home`` is the folder of this file."""
        for parent in list(root.iter()):
            self._homes[parent] = home
            if any(child.tag == "include" for child in parent):
                parent[:] = [new for child in parent for new in self._resolve(child, home)]

    def _resolve(self, child: Element, home: Path) -> list[Element]:
        if child.tag != "include":
            return [child]
        name = child.get("file", "")
        place = self._read(Path(name), name, home)
        if place in self._included:
            raise self._refuse(f"one that includes {describe(name, 30)} twice or in a circle", "each file once")
        self._included.add(place)
        root = self._parse(self._files[place], name)
        self._splice(root, Path(place).parent)
        return list(root)

    def _leave_out_textures(self, root: Element, folders: dict[str, str]) -> None:
        """Leave out textures whose files may not be read, or are missing: they change how things look, and no more."""
        missing = set()
        for parent in list(root.iter()):
            for texture in [child for child in parent if child.tag == "texture"]:
                try:
                    for _, given in _iterate_files(texture):
                        self._find_asset(texture, given, folders)
                except DesignError:
                    parent.remove(texture)
                    missing.add(texture.get("name") or Path(texture.get("file", "")).stem)
        for parent in list(root.iter()):
            if parent.tag == "material" and parent.get("texture") in missing:
                parent.attrib.pop("texture")
            parent[:] = [child for child in parent if child.tag != "layer" or child.get("texture") not in missing]

    def _take_assets(self, root: Element, folders: dict[str, str]) -> dict[str, bytes]:
        """Content of the files of all assets, which are named anew: a number, and the old name as MuJoCo's default."""
        assets, keys = {}, dict[str, str]()
        for element in root.iter():
            for attribute, given in _iterate_files(element):
                place = self._find_asset(element, given, folders)
                key = keys.setdefault(place, f"{len(keys)}/{Path(place).name}")
                element.set(attribute, key)
                assets[key] = self._files[place]
        return assets

    def _find_asset(self, element: Element, given: str, folders: dict[str, str]) -> str:
        folder = Path(folders["texturedir" if element.tag == "texture" else "meshdir"])
        name = Path(given).name if folders["strippath"] == "true" else given
        return self._read(folder / name, name, self._homes[element])

    def _read(self, first: Path, name: str, home: Path) -> str:
        """Read the file at ``first`` from the main file's folder, else at ``name`` from ``home``; the place found."""
        content = None
        try:
            for place in (os.path.normpath(first), os.path.normpath(home / name)):
                content = self._files.get(place) or read_below(self._folder, place)
                if content is not None:
                    break
        except PermissionError:
            raise self._refuse(f"one that names {describe(name, 60)}", _ALLOWED) from None
        if content is None:
            raise self._refuse(f"one that names {describe(name, 40)}, which does not exist", _ALLOWED)
        self._files[place] = content
        if len(self._files) > FILES_MOST or sum(map(len, self._files.values())) > BYTES_MOST:
            allowed = f"at most {FILES_MOST} files of {BYTES_MOST // 1_000_000} MB in all"
            raise self._refuse(f"one that names {len(self._files)} files, or too large ones", allowed)
        return place

    def _refuse(self, reason: str, allowed: str) -> DesignError:
        return refusal(self._what, reason, allowed)


def _iterate_files(element: Element) -> list[tuple[str, str]]:
    """Attributes of an element that name files, with their values."""
    return [(attribute, given) for attribute, given in element.items() if attribute.startswith("file") and given]


def _take_folders(root: Element) -> dict[str, str]:
    """Folders of assets by the last compiler that names them, taken out of the document."""
    folders = {"meshdir": "", "texturedir": "", "strippath": "false"}
    for compiler in root.iter("compiler"):
        if (both := compiler.attrib.pop("assetdir", None)) is not None:
            folders.update(meshdir=both, texturedir=both)
        folders.update({key: compiler.attrib.pop(key) for key in folders if key in compiler.attrib})
    return folders


def _count_pixels(content: bytes) -> int:
    """Pixels of a PNG file by its header, which a few bytes can say to be many; of other formats none."""
    is_picture = content.startswith(_PNG) and len(content) >= 24
    return int.from_bytes(content[16:20], "big") * int.from_bytes(content[20:24], "big") if is_picture else 0


class _TooMuch(Exception):
    """More elements, or deeper ones, than allowed: what there is and what is allowed."""


@final
class _Builder(ElementTree.TreeBuilder):
    """Builds a tree up to the limits; ``n_element`` elements were built before."""

    def __init__(self, n_element: int) -> None:
        super().__init__()
        self._n_element, self._depth = n_element, 0

    def start(self, tag: str, attrs: dict[str, str], /) -> Element:
        """Begin an element."""
        self._n_element += 1
        self._depth += 1
        if self._n_element > ELEMENTS_MOST:
            raise _TooMuch(f"more than {ELEMENTS_MOST} elements", f"at most {ELEMENTS_MOST}")
        if self._depth > DEPTH_MOST:
            raise _TooMuch(f"more than {DEPTH_MOST} nested elements", f"at most {DEPTH_MOST}")
        return super().start(tag, attrs)

    def end(self, tag: str, /) -> Element:
        """End an element."""
        self._depth -= 1
        return super().end(tag)
