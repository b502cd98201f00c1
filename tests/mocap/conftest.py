"""Small Motive CSVs written by hand, and recordings made up from shapes."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.design.presets import PAPER
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.recordings.motive_csv import read_motive
from spiraltrunk.mocap.recordings.take import Take
from spiraltrunk.mocap.session.prediction import predict
from spiraltrunk.mocap.signal.registration import Motion
from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions, build_synthetic_take

REAL = Path(__file__).parents[3] / "shared" / "mocap"

PAIRS = (
    "Format Version,{version},Take Name,Take 1,Take Notes,,Capture Frame Rate,{rate},Export Frame Rate,{rate},"
    "Capture Start Time,2026-01-05 03.49.50.755 PM,Total Frames in Take,{frames},Total Exported Frames,{frames},"
    "Rotation Type,{rotation},Length Units,{unit},Coordinate Space,{space}"
)


@pytest.fixture
def write() -> Callable[..., bytes]:
    """The bytes of a file: columns as (type, name, id, quantity, axis), rows of cells after frame and time."""

    def write(
        columns: list[tuple[str, str, str, str, str]], rows: list[list[object]], *, version: str = "1.23",
        unit: str = "Meters", rotation: str = "Quaternion", space: str = "Global", rate: str = "100.000000",
        first: int = 0, labels: bool = True, code: bool = False, end: str = "\r\n",
    ) -> bytes:  # fmt: skip
        pairs = PAIRS.format(version=version, unit=unit, rotation=rotation, space=space, rate=rate, frames=len(rows))
        lead = ["", ""] if code else [""]
        lines = [pairs, ""]
        for i, label in enumerate(("Type", "Name", "ID", "")):
            cells = [column[i] if i != 2 else f'"{column[i]}"' for column in columns]
            lines.append(",".join(["", label if labels else "", *lead[1:], *cells]))
        head = ["Frame", "Time (Seconds)" if labels else "Time", *(["TimeCode"] if code else [])]
        lines.append(",".join([*head, *(column[4] for column in columns)]))
        for i, row in enumerate(rows):
            number = first + i
            stamp = [str(number), f"{number / float(rate):.3f}", *(["15:26:46:12.02"] if code else [])]
            lines.append(",".join([*stamp, *map(str, row)]))
        return (end.join(lines) + end).encode()

    return write


@pytest.fixture
def read() -> Callable[..., Take]:
    """Read bytes as a file named take.csv."""

    def read(data: bytes, axes: str = "y-up", rotations: str = "quaternion") -> Take:
        return read_motive(io.BytesIO(data), source="take.csv", axes=axes, rotations=rotations)

    return read


def columns_of_body(name: str, ident: str = "A1", quaternion: str = "XYZW") -> list[tuple[str, str, str, str, str]]:
    rotation = [("Rigid Body", name, ident, "Rotation", axis) for axis in quaternion]
    position = [("Rigid Body", name, ident, "Position", axis) for axis in "XYZ"]
    return [*rotation, *position, ("Rigid Body", name, ident, "Mean Marker Error", "")]


def columns_of_marker(name: str, ident: str = "M1", kind: str = "Marker") -> list[tuple[str, str, str, str, str]]:
    return [(kind, name, ident, "Position", axis) for axis in "XYZ"]


@pytest.fixture
def body() -> Callable[..., list[tuple[str, str, str, str, str]]]:
    return columns_of_body


@pytest.fixture
def marker() -> Callable[..., list[tuple[str, str, str, str, str]]]:
    return columns_of_marker


BENDING = Run(name="bend", kind="bend-dorsal", steps=4, step=0.02)
RESTS = tuple(Run(name=f"rest-{tilt}", kind="rest", theta_0=np.radians(90.0 - tilt)) for tilt in (0, 45))


@pytest.fixture
def protocol() -> Protocol:
    """A short session: a bending of five shapes, and rest at two tilts."""
    return Protocol(name="short", runs=(BENDING, *RESTS), axes="y-up")


@pytest.fixture
def rehearse(protocol: Protocol) -> Callable[..., Take]:
    """A recording of a run as a model has it, somewhere in the room; ``shift`` moves points in the model's frame."""

    def rehearse(
        name: str, *, model: str = "reference", noise: float = 1e-4, seed: int = 0, yaw: float = 0.7,
        sections: tuple[int, ...] = (1, 3, 5, 7, 9, 11, 13, 15), shift: np.ndarray | float = 0.0, hold: float = 0.8,
    ) -> Take:  # fmt: skip
        run = protocol.run(name)
        found = predict(PAPER, build_schedule(PAPER, protocol, run), model=model)
        frame = Motion(rotation=Rotation.from_euler("y", yaw).as_matrix(), shift=np.array([0.4, 1.3, -2.0]))
        rehearsal = CameraOptions(
            rate=60.0, hold=hold, move=0.4, noise=noise, frame=frame, sections=sections, seed=seed
        )  # fmt: skip
        return build_synthetic_take(PAPER, found.points + shift, found.rotation, run.theta_0, rehearsal)

    return rehearse
