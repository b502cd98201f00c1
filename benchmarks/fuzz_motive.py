"""Mutated Motive CSVs: each one gives a take or a `TakeError`, soon and in little memory.

Small whole files of every kind are cut, spliced, and have bytes, cells and lines changed, doubled and swapped. Nothing
but a take or a `TakeError` may come out; what does is written to a file, with its number, and ends the run. The slowest
parse and the process's memory are told.
"""

from __future__ import annotations

import argparse
import io
import json
import random
import resource
import sys
import time
from pathlib import Path

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.recordings.motive_csv import read_motive
from spiraltrunk.mocap.recordings.take import Take

SLOWEST = 1.0
"""Time that a small file may take [s]."""

TOKENS = (
    b',|,,|\r\n|\n|\r|"|""|nan|inf|-inf|1e400|-|.|1_0|0x1|;|\t|\0|\xef\xbb\xbf|\xff\xfe|\xe9|Frame|Type|Name|ID|Position|'
    b"Rotation|Rigid Body|Rigid Body Marker|Marker|Bone|X|Y|Z|W|Meters|Inches|Quaternion|XYZ|Global|Local|1.21|1.25|"
    b"2.0|Mean Marker Error|TimeCode|99999999999999999999|1,5|0,0,0,0|Export Frame Rate|Length Units|Format Version"
).split(b"|")
"""What is put in."""

HEAD = (
    "Format Version,{version},Take Name,Take,Take Notes,,Capture Frame Rate,100.000000,Export Frame Rate,100.000000,"
    "Capture Start Time,2026-01-05 03.49.50.755 PM,Total Frames in Take,4,Total Exported Frames,4,Rotation Type,"
    "Quaternion,Length Units,{unit},Coordinate Space,Global\r\n\r\n"
)


def build_seeds() -> list[bytes]:
    """Small files of the kinds that Motive writes."""
    body = "0.1,0.2,0.3,0.927362,1.5,-0.25,0.125,0.0002"
    blank = "," * 7
    bodies = (
        HEAD.format(version="1.23", unit="Meters")
        + ",Type" + ",Rigid Body" * 8 + "\r\n,Name" + ",section_01" * 8 + "\r\n,ID" + ',"A3C3"' * 8 + "\r\n"
        + ",," + "Rotation," * 4 + "Position," * 3 + "Mean Marker Error\r\nFrame,Time (Seconds),X,Y,Z,W,X,Y,Z,\r\n"
        + f"0,0.000000,{body}\r\n1,0.010000,{blank}\r\n2,0.020000,{body}\r\n3,0.030000,{body}\r\n"
    )  # fmt: skip
    markers = (
        HEAD.format(version="1.21", unit="Millimeters").replace("Take Notes,,", "")
        + ",," + ",".join(["Rigid Body Marker"] * 3 + ["Marker"] * 3) + "\r\n,," + ",".join(["a:1"] * 3 + ["a:1"] * 3)
        + "\r\n,," + ",".join(['"7"'] * 6) + "\r\n,," + ",".join(["Position"] * 6) + "\r\nFrame,Time,X,Y,Z,X,Y,Z\r\n"
        + "10,0.1,1,2,3,,,\r\n11,0.11,1,2,3,4,5,6\r\n12,0.12,1,2,3,4.5,5,6\r\n"
    )  # fmt: skip
    coded = (
        HEAD.format(version="1.24", unit="centimeters")
        + ",Type,,Marker,Marker,Marker,Bone\n,Name,,m,m,m,b\n,ID,,1,1,1,2\n,,,Position,Position,Position,Position\n"
        + "Frame,Time (Seconds),TimeCode,X,Y,Z,X\n"
        + "0,0.0,15:26:46:12.02,1.5,2.5,3.5,9\n1,0.01,15:26:46:12.03,1.5,2.5,,x\n"
    )
    quoted = markers.replace("1,2,3,4,5,6", '"1","2","3","4","5","6"')
    return [text.encode() for text in (bodies, markers, coded, quoted, "\ufeff" + coded.replace("\n", "\r"))]


def mutate(seeds: list[bytes], draw: random.Random) -> bytes:
    """One file with one to six changes."""
    data = bytearray(draw.choice(seeds))
    for _ in range(draw.randint(1, 6)):
        at, kind = draw.randrange(len(data) + 1), draw.randrange(9)
        end = min(len(data), at + draw.randint(0, 40))
        if kind == 0:
            data[at:at] = draw.choice(TOKENS)
        elif kind == 1:
            del data[at:end]
        elif kind == 2:
            data[at:at] = data[at:end] * draw.randint(1, 3)
        elif kind == 3 and at < len(data):
            data[at] = draw.randrange(256)
        elif kind == 4:
            data[at:end] = draw.choice(TOKENS)
        elif kind == 5:
            del data[at:]
        elif kind == 6:
            other = draw.choice(seeds)
            start = draw.randrange(len(other))
            data[at:end] = other[start : start + draw.randint(1, 200)]
        elif kind == 7:
            swap_cells(data, draw, b",")
        else:
            swap_cells(data, draw, b"\n")
    return bytes(data)


def swap_cells(data: bytearray, draw: random.Random, divider: bytes) -> None:
    """Swap two cells or lines."""
    parts = bytes(data).split(divider)
    i, j = draw.randrange(len(parts)), draw.randrange(len(parts))
    parts[i], parts[j] = parts[j], parts[i]
    data[:] = divider.join(parts)


def check(data: bytes) -> bool:
    """Whether it is a take; what a take promises is looked at."""
    try:
        take = read_motive(io.BytesIO(data), source="mutated.csv", axes="y-up")
    except TakeError as error:
        if not str(error).startswith("'mutated.csv'"):
            raise AssertionError(f"the error does not name the file: {error}") from error
        return False
    verify(take)
    return True


def verify(take: Take) -> None:
    """A take's arrays fit each other and hold no infinity."""
    count = len(take.frame)
    tracks = (*take.bodies, *take.markers)
    sound = count > 0 and len(take.time) == count and bool(tracks) and (np.diff(take.frame) > 0).all()
    sound &= bool(np.isfinite(take.time).all()) and take.rate > 0
    for track in tracks:
        sound &= track.position.shape == (count, 3) and not np.isinf(track.position).any()
        sound &= (
            track.is_stale.shape == (count,) and not (track.is_stale & ~np.isfinite(track.position).all(axis=1)).any()
        )
    for body in take.bodies:
        size = np.linalg.norm(body.quaternion_wxyz, axis=1)
        sound &= bool((np.abs(size[np.isfinite(size)] - 1) < 1e-9).all())
    if not sound:
        raise AssertionError("the take is not sound")


def run(count: int, seconds: float, seed: int) -> dict[str, float]:
    """Parse mutated files until there are so many or the time is over.

    Raises:
        AssertionError: with the number of the file, for a take that is not sound or a parse that is slow.
    """
    draw, seeds = random.Random(seed), build_seeds()
    for data in seeds:
        if not check(data):
            raise AssertionError("a file that is not mutated is refused")
    done = taken = 0
    slowest, began = 0.0, time.perf_counter()
    while done < count and time.perf_counter() - began < seconds:
        data = mutate(seeds, draw)
        start = time.perf_counter()
        try:
            taken += check(data)
        except BaseException:
            Path("fuzz_motive_failure.csv").write_bytes(data)
            print(f"file {done} of seed {seed}: fuzz_motive_failure.csv", file=sys.stderr)
            raise
        slowest = max(slowest, time.perf_counter() - start)
        done += 1
        if done % 20_000 == 0:
            print(f"{done} files, {taken} of them takes, {done / (time.perf_counter() - began):.0f}/s", file=sys.stderr)
    if slowest > SLOWEST:
        raise AssertionError(f"a file took {slowest:.2f} s; allowed: {SLOWEST} s")
    spent = time.perf_counter() - began
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {
        "files": done,
        "takes": taken,
        "seconds": spent,
        "per_s": done / spent,
        "slowest_s": slowest,
        "memory_mb": memory,
    }


def main() -> int:
    """Run and print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1_000_000, help="files (default 1000000)")
    parser.add_argument("--seconds", type=float, default=1e9, help="time after which it ends (default: none)")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    print(json.dumps(run(arguments.count, arguments.seconds, arguments.seed), indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
