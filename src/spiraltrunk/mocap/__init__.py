"""Motion capture: recordings, the static shapes in them, and their deviations from a model."""

from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.toml import load_protocol
from spiraltrunk.mocap.recordings.load import load_take
from spiraltrunk.mocap.recordings.take import Take
from spiraltrunk.mocap.session.session import SessionSettings, build_session, read_session
from spiraltrunk.mocap.session.shapes_json import load_shapes, write_shapes
from spiraltrunk.mocap.signal.deviation import compute_deviation

__all__ = [
    "Protocol",
    "Run",
    "SessionSettings",
    "Take",
    "build_session",
    "compute_deviation",
    "load_protocol",
    "load_shapes",
    "load_take",
    "read_session",
    "write_shapes",
]
