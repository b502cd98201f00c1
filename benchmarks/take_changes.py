"""Changes of recordings that `attack_takes` makes: of bytes, cells, rows, headers, and of the parts of a C3D file.

A change is a function of a file's bytes and a draw that returns other bytes. `ATTACKS` holds them by the kind of file.
"""

from __future__ import annotations

import csv
import gzip
import io
import random
import re
import struct
from collections.abc import Callable

NUMBERS = (
    "nan", "NaN", "inf", "-inf", "1e300", "-1e300", "1e308", "1e-308", "1e999", "-0", "0", "1e5", "-1e5", "9999",
    "1e9", "2147483648", "9223372036854775808", "1,5", "1_0", "0x10", "1e", ".", "-", "+", "a", "", "  ", '"', "'",
    "\u0661", "\xff", "\x00", "1.2.3", "--1", "true", "null",
)  # fmt: skip
"""What a cell becomes."""

WORDS = (
    "Rigid Body", "Rigid Body Marker", "Marker", "Bone", "Bone Marker", "Position", "Rotation", "Mean Marker Error",
    "Marker Quality", "X", "Y", "Z", "W", "Frame", "Time (Seconds)", "TimeCode", "section_00", "section_01",
    "section_17", "section_99", "section_05", "section_05:Marker1", "base", "Type", "Name", "ID", "Parent", "",
)  # fmt: skip
"""What a cell of the header becomes."""

HEADERS = (
    ("Format Version,1.23", "Format Version,1.1"), ("Format Version,1.23", "Format Version,1.25"),
    ("Format Version,1.23", "Format Version,9.99"), ("Format Version,1.23", "Format Version,"), ("Format Version,", ""),
    ("Rotation Type,Quaternion", "Rotation Type,XYZ"), ("Rotation Type,Quaternion", "Rotation Type,"),
    ("Length Units,Meters", "Length Units,Millimeters"), ("Length Units,Meters", "Length Units,Feet"),
    ("Length Units,Meters", "Length Units,"), ("Coordinate Space,Global", "Coordinate Space,Local"),
    ("Export Frame Rate,20", "Export Frame Rate,0"), ("Export Frame Rate,20", "Export Frame Rate,1e9"),
    ("Export Frame Rate,20", "Export Frame Rate,nan"), ("Export Frame Rate,20", "Export Frame Rate,-20"),
    ("Capture Frame Rate,20", "Capture Frame Rate,inf"), ("Rigid Body Marker", "Marker"), ("Rigid Body", "Bone"),
    ("Rotation", "Position"), ("Position", "Rotation"), ("section_", "Section "), ("section_0", "section_1"),
    ("section_", "trunk:section_"), ("base", "section_03"), (":Marker", ":"), (":Marker2", ":Marker1"), (",X,", ",Y,"),
    ("Frame,Time (Seconds)", "Time (Seconds),Frame"), ("Frame,", "Frame,TimeCode,"), ("Frame,", ""),
)  # fmt: skip
"""Headers of other versions, exports and names: what is replaced, and by what."""

Change = Callable[[bytes, random.Random], bytes]


def change_bytes(data: bytes, draw: random.Random) -> bytes:
    """Bytes are put in the place of others."""
    changed = bytearray(data)
    for _ in range(draw.choice((1, 3, 30))):
        changed[draw.randrange(len(changed))] = draw.choice((draw.randrange(256), 0, 44, 10, 13, 34, 255))
    return bytes(changed)


def splice(data: bytes, draw: random.Random) -> bytes:
    """A part is cut out, repeated or moved."""
    at = draw.randrange(len(data))
    end = at + draw.choice((1, 20, 500, len(data)))
    part, kind = data[at:end], draw.randrange(3)
    rest = data[:at] + data[end:]
    if kind == 0:
        return rest
    if kind == 1:
        return data[:at] + part * draw.choice((2, 3, 20)) + data[end:]
    to = draw.randrange(len(rest) + 1)
    return rest[:to] + part + rest[to:]


def truncate(data: bytes, draw: random.Random) -> bytes:
    """The file is cut off, or is empty."""
    return data[: draw.choice((0, 1, draw.randrange(len(data)), draw.randrange(len(data)), len(data) - 1))]


def encode(data: bytes, draw: random.Random) -> bytes:
    """Another encoding."""
    text = data.decode("latin-1")
    kinds: tuple[Callable[[], bytes], ...] = (
        lambda: text.encode("utf-16"), lambda: text.encode("utf-16-le"), lambda: text.encode("utf-32"),
        lambda: b"\xef\xbb\xbf" * draw.randint(1, 3) + data, lambda: gzip.compress(data, 1),
        lambda: text.replace("e", "\xe9").encode("utf-8"), lambda: text.replace("e", "\xe9").encode("latin-1"),
        lambda: text.encode("cp500"), lambda: text.replace("\n", draw.choice("\r\x0b\x0c\x85\x1c")).encode("utf-8"),
        lambda: data.replace(b",", draw.choice((b";", b"\t", b", ", b",,"))), lambda: data.replace(b"\n", b"\0\n"),
    )  # fmt: skip
    return draw.choice(kinds)()


def _rows(data: bytes) -> list[list[str]]:
    return list(csv.reader(io.StringIO(data.decode("latin-1").replace("\0", ""), newline="")))


def _join(rows: list[list[str]]) -> bytes:
    text = io.StringIO(newline="")
    csv.writer(text).writerows(rows)
    return text.getvalue().encode("utf-8", "surrogatepass")


def _tabular(change: Callable[[list[list[str]], random.Random], None]) -> Change:
    """A change of a table's rows as one of its bytes; what is no table any more stays as it is."""

    def changed(data: bytes, draw: random.Random) -> bytes:
        try:
            rows = _rows(data)
        except csv.Error:
            return data
        if len(rows) < 3 or not any(rows):
            return data
        change(rows, draw)
        return _join(rows)

    changed.__doc__ = change.__doc__
    return changed


def change_cells(rows: list[list[str]], draw: random.Random) -> None:
    """Cells become other numbers or words."""
    for _ in range(draw.choice((1, 5, 300))):
        row = draw.choice(rows)
        if row:
            row[draw.randrange(len(row))] = draw.choice(NUMBERS if draw.random() < 0.8 else WORDS)


def change_column(rows: list[list[str]], draw: random.Random) -> None:
    """A column, or three, becomes one number, grows by a factor, or is swapped with another."""
    first = draw.choice((7, 7, 0))
    column, other = (draw.randrange(max(map(len, rows))) for _ in range(2))
    value, factor, kind = draw.choice(NUMBERS), draw.choice((0.0, -1.0, 1e3, 1e300, 1e-300, 1.0001)), draw.randrange(4)
    for row in rows[first:]:
        for place in range(column, min(len(row), column + draw.choice((1, 1, 3)))):
            if kind == 0:
                row[place] = value
            elif kind == 1:
                with_factor = re.fullmatch(r"-?\d+\.?\d*(e-?\d+)?", row[place])
                row[place] = repr(float(row[place]) * factor) if with_factor else row[place]
            elif kind == 2 and other < len(row):
                row[place], row[other] = row[other], row[place]
            elif kind == 3:
                row[place] = ""


def change_rows(rows: list[list[str]], draw: random.Random) -> None:
    """Rows are dropped, doubled, swapped, shuffled or repeated."""
    at, kind = draw.randrange(len(rows)), draw.randrange(6)
    end = at + draw.choice((1, 2, 50))
    if kind == 0:
        del rows[at:end]
    elif kind == 1:
        rows[at:at] = [list(row) for row in rows[at:end]]
    elif kind == 2:
        other = draw.randrange(len(rows))
        rows[at], rows[other] = rows[other], rows[at]
    elif kind == 3:
        body = rows[7:]
        draw.shuffle(body)
        rows[7:] = body
    elif kind == 4:
        rows[7:] = [list(row) for row in rows[7:]] * draw.choice((2, 40))
    else:
        del rows[draw.choice((7, 8, 9, 11)) :]


def change_width(rows: list[list[str]], draw: random.Random) -> None:
    """Rows get more or fewer cells, some a million."""
    for _ in range(draw.choice((1, 3))):
        row = draw.choice(rows)
        kind = draw.randrange(5)
        if kind == 0:
            del row[draw.randrange(len(row) + 1) :]
        elif kind == 1:
            row.extend(row * draw.choice((1, 9)))
        elif kind == 2:
            row.extend([""] * draw.choice((1, 1000, 1_000_000)))
        elif kind == 3:
            row.append(draw.choice("a1\"'") * draw.choice((1000, 3_000_000)))
        else:
            row.insert(0, draw.choice(NUMBERS))


def change_times(rows: list[list[str]], draw: random.Random) -> None:
    """Frames and times jump, stand still, run backwards or are huge."""
    column, kind = draw.randrange(2), draw.randrange(6)
    for i, row in enumerate(rows[7:]):
        if len(row) > 2:
            values = (f"1{'0' * i}", "5", str(-i), str(i * 10**9), f"{i * 1e-12:.15f}", str(2**63 - 5 + i))
            row[column] = values[kind]


def change_numbers(rows: list[list[str]], draw: random.Random) -> None:
    """Many positions and angles are a little, or much, off."""
    share, size = draw.choice((0.01, 0.3, 1.0)), draw.choice((1e-6, 1e-3, 0.1, 1.0, 100.0))
    for row in rows[7:]:
        for place in range(2, len(row)):
            if draw.random() < share and re.fullmatch(r"-?\d+\.\d+", row[place]):
                row[place] = f"{float(row[place]) + draw.gauss(0.0, size):.6f}"


def change_gaps(rows: list[list[str]], draw: random.Random) -> None:
    """Tracks are not seen for a while, or stand still."""
    columns = max(map(len, rows))
    for _ in range(draw.choice((1, 10, 60))):
        column, begin = draw.randrange(2, max(3, columns)), draw.randrange(7, max(8, len(rows)))
        width, held = draw.choice((1, 3, 8)), draw.random() < 0.3
        for i in range(begin, min(len(rows), begin + draw.choice((2, 10, 100)))):
            for place in range(column, min(len(rows[i]), column + width)):
                rows[i][place] = rows[i - 1][place] if held and place < len(rows[i - 1]) else ""


def change_header(data: bytes, draw: random.Random) -> bytes:
    """The header of another version, unit, rotation type or naming."""
    for _ in range(draw.choice((1, 1, 2))):
        old, new = draw.choice(HEADERS)
        data = data.replace(old.encode(), new.encode())
    return data


def set_words(data: bytes, draw: random.Random, start: int, end: int) -> bytes:
    """Words and floats of a part become extreme numbers."""
    changed, end = bytearray(data), min(end, len(data))
    for _ in range(draw.choice((1, 1, 4, 40))):
        at = draw.randrange(start, max(start + 1, end - 4))
        kind = draw.randrange(4)
        if kind == 0:
            changed[at : at + 1] = bytes([draw.randrange(256)])
        elif kind == 1:
            struct.pack_into(
                "<H", changed, min(at & ~1, len(changed) - 2), draw.choice((0, 1, 2, 255, 0x7FFF, 0x8000, 0xFFFF))
            )
        elif kind == 2:
            value = draw.choice((float("nan"), float("inf"), 1e38, -1e38, 1e-40, 0.0, -1.0))
            struct.pack_into("<f", changed, min(at & ~3, len(changed) - 4), value)
        else:
            changed[at : at + 4] = draw.choice((b"\xff" * 4, b"\0" * 4, b"\x80\0\0\0", b"\xff\xff\xff\x7f"))
    return bytes(changed)


def _pointers(data: bytes) -> tuple[int, int]:
    """Bytes at which parameters and data begin."""
    if len(data) < 1024:
        return 0, len(data)
    return 512 * max(1, data[0] - 1), min(len(data) - 8, 512 * max(1, struct.unpack_from("<H", data, 16)[0] - 1))


def c3d_header(data: bytes, draw: random.Random) -> bytes:
    """The header: key, counts, frames, pointers, rate."""
    return set_words(data, draw, 0, 24 if draw.random() < 0.7 else 512) if len(data) > 600 else data


def c3d_parameters(data: bytes, draw: random.Random) -> bytes:
    """Parameters: names, lengths, types, dimensions and values."""
    start, end = _pointers(data)
    return set_words(data, draw, start, end) if end - start > 8 else data


def c3d_records(data: bytes, draw: random.Random) -> bytes:
    """The lengths, types and dimensions round the names of groups and parameters."""
    changed = bytearray(data)
    names = [found.start() for found in re.finditer(rb"[A-Z][A-Z_0-9]{3,}", data)]
    for _ in range(draw.choice((1, 2, 5)) if names else 0):
        at = draw.choice(names) + draw.randint(-3, 16)
        if 0 <= at < len(changed):
            changed[at] = draw.choice((0, 1, 2, 4, 127, 128, 254, 255, draw.randrange(256)))
    return bytes(changed)


def c3d_words(data: bytes, draw: random.Random) -> bytes:
    """Names and units become others of the same length."""
    pairs = ((b"POINT", b"POINS"), (b"RATE", b"TARE"), (b"UNITS", b"UNITZ"), (b"LABELS", b"LABELZ"), (b"mm", b"xx"),
             (b"section_", b"SECTION "), (b"Marker1", b"Marker2"), (b"Marker", b"\xe9\xe9\xe9\xe9\xe9\xe9"),
             (b"FRAMES", b"FRAMEZ"), (b"SCALE", b"SCALD"), (b"USED", b"USEE"), (b"section_05", b"section_99"),
             (b"ANALOG", b"ANALOH"), (b"DATA_START", b"DATA_STARD"))  # fmt: skip
    old, new = draw.choice(pairs)
    return data.replace(old, new)


def c3d_data(data: bytes, draw: random.Random) -> bytes:
    """The positions and residuals."""
    _, start = _pointers(data)
    return set_words(data, draw, start, len(data)) if len(data) > 600 else data


def c3d_blocks(data: bytes, draw: random.Random) -> bytes:
    """Blocks of 512 bytes are dropped, doubled, swapped or put in."""
    blocks = [data[at : at + 512] for at in range(0, len(data), 512)]
    at, other, kind = draw.randrange(len(blocks)), draw.randrange(len(blocks)), draw.randrange(4)
    if kind == 0:
        del blocks[at]
    elif kind == 1:
        blocks[at:at] = blocks[other : other + 3]
    elif kind == 2:
        blocks[at], blocks[other] = blocks[other], blocks[at]
    else:
        blocks.insert(at, draw.randbytes(512))
    return b"".join(blocks)


TEXT: dict[str, Change] = {
    "bytes": change_bytes, "splice": splice, "truncate": truncate, "encoding": encode,
    "cells": _tabular(change_cells), "width": _tabular(change_width),
}  # fmt: skip
CSV: dict[str, Change] = {
    **TEXT, "column": _tabular(change_column), "rows": _tabular(change_rows), "times": _tabular(change_times),
    "header": change_header, "numbers": _tabular(change_numbers), "gaps": _tabular(change_gaps),
}  # fmt: skip
C3D: dict[str, Change] = {
    "C3D header": c3d_header, "C3D parameters": c3d_parameters, "C3D records": c3d_records, "C3D words": c3d_words,
    "C3D data": c3d_data, "C3D blocks": c3d_blocks, "C3D truncate": truncate, "C3D bytes": change_bytes,
}  # fmt: skip
ATTACKS = {"csv": CSV, "c3d": C3D, "bench": TEXT, "protocol": TEXT}
"""Attacks by the kind of file."""
