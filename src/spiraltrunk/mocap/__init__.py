"""The judge: recordings of motion capture become static shapes, and shapes are held against a model."""

from spiraltrunk.mocap.compare import compute_deviation
from spiraltrunk.mocap.load import load_take
from spiraltrunk.mocap.protocol import Protocol, Run
from spiraltrunk.mocap.protocol_file import load_protocol
from spiraltrunk.mocap.session import SessionSettings, build_session, read_session
from spiraltrunk.mocap.shapes_file import load_shapes, write_shapes
from spiraltrunk.mocap.take import Take

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
