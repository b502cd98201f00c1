"""A single file is replaced where it is one of ours and unchanged, in every format, and read by others as before."""

from __future__ import annotations

import errno
import io
import os
import re
import struct
import tomllib
import xml.etree.ElementTree as ET
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from PIL import Image

from spiraltrunk.design import format_design
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import OutputError
from spiraltrunk.files.output_file import FORMATS, check_output_file, write_output_file


def draw(form: str) -> bytes:
    file = io.BytesIO()
    Figure(figsize=(1, 1)).savefig(file, format=form)
    return file.getvalue()


def build(form: str) -> bytes:
    if form == "html":
        return b"<!doctype html>\n<html><head><title>a</title></head><body><p>b</p></body></html>\n"
    return format_design(PAPER).encode() if form == "toml" else draw(form)


@pytest.mark.parametrize("form", FORMATS)
def test_twice_is_no_matter(form: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{form}"
    for _ in range(3):
        write_output_file(path, build(form), form)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("form", FORMATS)
def test_it_can_be_read_as_before(form: str, tmp_path: Path) -> None:
    path, plain = tmp_path / f"a.{form}", build(form)
    write_output_file(path, plain, form)
    data = path.read_bytes()
    if form == "toml":
        assert tomllib.loads(data.decode()) == tomllib.loads(plain.decode())
    elif form == "svg":
        assert ET.fromstring(data).tag == ET.fromstring(plain).tag
    elif form == "html":
        assert data.startswith(plain)
        assert re.fullmatch(rb"<!-- [^-]*-256 of the rest: [0-9a-f]{64} -->\n", data.removeprefix(plain))
    elif form == "pdf":
        assert data.startswith(plain)
        assert b"%%EOF" in data[-1024:]  # Where readers look for it (ISO 32000-1, annex H.3, note 18).
    else:
        with Image.open(path) as picture, Image.open(io.BytesIO(plain)) as before:
            assert "SHA-256" in picture.text["Comment"]
            np.testing.assert_array_equal(np.asarray(picture), np.asarray(before))
        assert_chunks_are_whole(data)


def assert_chunks_are_whole(data: bytes) -> None:
    """Length, type and CRC of every chunk (ISO/IEC 15948, section 5.3)."""
    place, kinds = 8, []
    while place < len(data):
        (length,) = struct.unpack(">I", data[place : place + 4])
        kinds.append(data[place + 4 : place + 8])
        body = data[place + 4 : place + 8 + length]
        assert struct.unpack(">I", data[place + 8 + length : place + 12 + length]) == (zlib.crc32(body),)
        place += 12 + length
    assert kinds[-2:] == [b"tEXt", b"IEND"]


@pytest.mark.parametrize("form", FORMATS)
def test_what_was_changed_since_or_never_ours_is_refused(form: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{form}"
    write_output_file(path, build(form), form)
    ours = path.read_bytes()
    middle = len(ours) // 2
    changed = (
        ours + b"# mine\n", b"# mine\n" + ours, ours[:-1], b"", b"mine", build(form), ours.replace(b"\n", b"\r\n", 1),
        ours[:middle] + bytes([ours[middle] ^ 1]) + ours[middle + 1 :], ours[:-1] + b" ",
    )  # fmt: skip
    for data in changed:
        path.write_bytes(data)
        with pytest.raises(OutputError, match=rf"a\.{form}' is not replaced: .*; allowed: a new file, or move") as told:
            write_output_file(path, build(form), form)
        assert "\n" not in str(told.value)
        assert path.read_bytes() == data
    path.write_bytes(ours)
    write_output_file(path, build(form), form)


@given(data=st.binary(max_size=200), form=st.sampled_from(FORMATS))
def test_any_file_of_anothers_is_refused(data: bytes, form: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("any") / "a"
    path.write_bytes(data)
    with pytest.raises(OutputError):
        check_output_file(path, form)


@pytest.mark.parametrize("form", FORMATS)
def test_a_place_that_cannot_be_written_is_refused_before_there_is_anything_to_write(
    form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "new" / "deep" / f"a.{form}"
    check_output_file(path, form)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(OutputError, match="cannot be written: File name too long"):
        check_output_file(tmp_path / f"{'a' * 300}.{form}", form)

    def refuse(place: Path) -> int:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(place))

    monkeypatch.setattr("spiraltrunk.files.atomic.acquire_lock", refuse)
    with pytest.raises(OutputError, match=rf"a\.{form}' cannot be written: Read-only file system; allowed: a place"):
        check_output_file(path, form)
    assert list(tmp_path.iterdir()) == []


def test_links_and_folders_are_refused(tmp_path: Path) -> None:
    write_output_file(tmp_path / "a.toml", build("toml"), "toml")
    (tmp_path / "link.toml").symlink_to(tmp_path / "a.toml")
    (tmp_path / "nowhere.toml").symlink_to(tmp_path / "nothing")
    os.mkfifo(tmp_path / "pipe.toml")
    for name in ("link.toml", "nowhere.toml", "pipe.toml"):
        with pytest.raises(OutputError, match="is not replaced"):
            write_output_file(tmp_path / name, build("toml"), "toml")
    with pytest.raises(OutputError, match="is a folder; allowed: a file"):
        write_output_file(tmp_path, build("toml"), "toml")
    with pytest.raises(OutputError, match=r"a\.toml' is a file; allowed: a folder"):
        write_output_file(tmp_path / "a.toml" / "b.toml", build("toml"), "toml")
