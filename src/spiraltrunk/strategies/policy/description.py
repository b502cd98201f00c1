"""Description of a policy: inputs and outputs of its networks, and what it was trained for; a JSON file beside them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any, NoReturn, final

from spiraltrunk.checks import check_count, check_number, check_text, check_type
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.errors import DesignError, UnknownName, Unquoted
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.strategies.moves import PHASES
from spiraltrunk.strategies.policy.network import ACTIVATIONS

FORMAT = "spiraltrunk policy 1"
"""Name and version of the format."""

CONTROL_MODES = ("pose-tension", "stroke")
"""What the networks command: set points of base and cables at every decision, or the parameters of a stroke."""

NETWORKS: Mapping[str, tuple[str, ...]] = {"pose-tension": ("action", "stage"), "stroke": ("action",)}
"""Networks of each control mode."""

LARGEST_LAYER, MOST_LAYERS = 2048, 8
"""Largest number of units of a layer, and of layers, that a file may have [-] (ours)."""

MOST_NAMES = 512
"""Largest number of inputs, outputs, stages or objects [-] (ours)."""

JOBS, SUPPORTS, ORIENTATIONS = ("grasp", "kick", "sweep"), ("hung", "ground"), ("lying", "upright")
"""Values of what a policy was trained for, as of `Strategy`."""

HOLDS = ("trunk", "fingers", "nothing")
"""What holds the object, as of `Strategy`."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Layers:
    """Sizes and activations of one network."""

    sizes: tuple[int, ...]
    """Number of inputs, of units of each hidden layer, and of outputs."""
    activation: str = "relu"
    """Activation of the hidden layers."""
    output: str = "linear"
    """Activation of the last layer."""

    def __post_init__(self) -> None:
        if not 2 <= len(self.sizes) <= MOST_LAYERS + 1:
            got = Unquoted(f"{len(self.sizes)} sizes")
            raise DesignError("policy.networks.sizes", got=got, allowed=f"2 to {MOST_LAYERS + 1}")
        for size in self.sizes:
            check_count("policy.networks.sizes", size, least=1, most=LARGEST_LAYER)
        for name in (self.activation, self.output):
            _check_choice("policy.networks.activation", name, tuple(ACTIVATIONS))


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Stage:
    """A stage of the task, as a policy distinguishes and reports it."""

    name: str
    """Name of the action, in the words of the demonstrated strategy."""
    phase: str
    """One of the four phases."""
    milestone: str | None = None
    """What it works towards, by the value of `Milestone`; None between milestones."""
    least: float = 0.0
    """Shortest time that demonstrations stayed in it [s]; it is not left earlier."""
    most: float = 290.0
    """Time after which it is left for the most likely next stage [s]."""
    after: tuple[str, ...] = ()
    """Names of the stages that may follow it; none for all."""
    visits: int = 1000
    """Largest number of times that it is entered in a run, that of the demonstrations."""

    def __post_init__(self) -> None:
        check_text("policy.stages.name", self.name, most=60)
        _check_choice("policy.stages.phase", self.phase, PHASES)
        if self.milestone is not None:
            _check_choice("policy.stages.milestone", self.milestone, tuple(each.value for each in Milestone))
        for name, value in (("least", self.least), ("most", self.most)):
            check_number(f"policy.stages.{name}", value, least=0.0, most=290.0)
        check_count("policy.stages.visits", self.visits, least=1, most=1000)
        check_count("number of policy.stages.after", len(self.after), least=0, most=MOST_NAMES)
        check_type("policy.stages.after", self.after, tuple)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class PolicyDescription:
    """Inputs and outputs of a policy's networks, and what it was trained for."""

    control_mode: str
    """One of CONTROL_MODES."""
    inputs: tuple[str, ...]
    """Names of the inputs of the networks, in order."""
    outputs: tuple[str, ...]
    """Names of the outputs of the network "action", in order."""
    networks: Mapping[str, Layers]
    """The networks of the control mode."""
    n_cable: int
    """Number of cables of its trunk."""
    job: str = "grasp"
    """What counts as success, as of `Strategy`."""
    support: str = "hung"
    """What supports its objects."""
    orientation: str = "lying"
    """Orientation of its objects."""
    has_fixed_orientation: bool = False
    """Whether that was chosen for the object at hand, as of `Strategy`."""
    holds: str = "trunk"
    """What holds the object."""
    needs_camera: bool = False
    """Whether it needs a camera."""
    objects: tuple[str, ...] = ("cylinder-60",)
    """Objects that a survey gives it."""
    widths: tuple[float, float] = (0.0, 0.15)
    """Least and greatest width of its objects [m]."""
    position: tuple[float, float] | None = None
    """Position of its objects on the ground [m]."""
    push: tuple[float, float] = (0.0, 0.0)
    """Displacement of its objects along the ground [m]."""
    stages: tuple[Stage, ...] = ()
    """Stages of its task; none where it has no memory of a stage."""
    latches: tuple[str, ...] = ()
    """Stages at whose start the load is remembered."""
    period: float = 0.1
    """Time between two decisions [s]."""
    smoothing: float = 0.1
    """Time constant of the critically damped filter of the set points [s]."""
    ventral_lead: float | None = None
    """Lead of one ventral cable before the other, over the stroke [-]; None sets no limit of the pulls."""
    longest: float = 120.0
    """Time after which it ends [s]."""
    weights_sha256: str = ""
    """SHA-256 of the file of weights, hexadecimal."""
    provenance: Mapping[str, Any] = field(default_factory=dict)
    """Where it comes from: seeds, versions, data, figures."""

    def __post_init__(self) -> None:
        for name, known in (
            ("control_mode", CONTROL_MODES), ("job", JOBS), ("support", SUPPORTS), ("orientation", ORIENTATIONS),
            ("holds", HOLDS),
        ):  # fmt: skip
            _check_choice(f"policy.{name}", getattr(self, name), known)
        for name in ("needs_camera", "has_fixed_orientation"):
            check_type(f"policy.{name}", getattr(self, name), bool)
        check_count("policy.n_cable", self.n_cable, least=1, most=16)
        for name, above, most in (("period", 0.0, 10.0), ("smoothing", 0.0, 10.0), ("longest", 0.0, 290.0)):
            check_number(f"policy.{name}", getattr(self, name), above=above, most=most)
        if self.ventral_lead is not None:
            check_number("policy.ventral_lead", self.ventral_lead, above=0.0, most=10.0)
        self._check_names()
        self._check_numbers()
        self._check_networks()

    def _check_names(self) -> None:
        for name in ("inputs", "outputs", "objects", "stages", "latches"):
            values = getattr(self, name)
            least = 1 if name in ("inputs", "outputs", "objects") else 0
            check_count(f"number of policy.{name}", len(values), least=least, most=MOST_NAMES)
            check_type(f"policy.{name}", values, tuple)
            for value in values if name != "stages" else ():
                check_text(f"policy.{name}", value)
        known = tuple(stage.name for stage in self.stages)
        for name, values in (("stages", known), ("inputs", self.inputs), ("outputs", self.outputs)):
            if len(set(values)) != len(values):
                raise DesignError(f"policy.{name}", got=Unquoted("a name twice"), allowed="each name once")
        for latch in self.latches:
            _check_choice("policy.latches", latch, known)
        for name in (name for stage in self.stages for name in stage.after):
            _check_choice("policy.stages.after", name, known)

    def _check_numbers(self) -> None:
        for name in ("widths", "push", "position"):
            values = getattr(self, name)
            if name == "position" and values is None:
                continue
            if not (isinstance(values, tuple) and len(values) == 2):
                raise DesignError(f"policy.{name}", got=values, allowed="two numbers")
            for value in values:
                check_number(f"policy.{name}", value, least=-10.0, most=10.0)

    def _check_networks(self) -> None:
        wanted = NETWORKS[self.control_mode]
        if tuple(sorted(self.networks)) != wanted:
            raise DesignError("policy.networks", got=sorted(self.networks), allowed=", ".join(wanted))
        ends = {"action": len(self.outputs), "stage": len(self.stages)}
        for name, layers in self.networks.items():
            first, last = layers.sizes[0], layers.sizes[-1]
            if (first, last) != (len(self.inputs), ends[name]):
                allowed = f"{len(self.inputs)} to {ends[name]}, the numbers of its inputs and outputs"
                raise DesignError(f"policy.networks.{name}", got=Unquoted(f"{first} to {last}"), allowed=allowed)


def format_description(description: PolicyDescription) -> str:
    """The description as JSON."""
    return json.dumps({"format": FORMAT, **asdict(description)}, indent=1, allow_nan=False) + "\n"


def parse_description(text: str) -> PolicyDescription:
    """The description in a JSON text.

    Raises:
        DesignError: where it is no JSON, of another format, or lacks, adds or misstates a value.
        UnknownName: for a value that is not in a list.
    """
    values = _parse_object(text)
    if values.pop("format", None) != FORMAT:
        raise DesignError("policy.format", got=Unquoted("another"), allowed=FORMAT)
    known = {each.name: each for each in fields(PolicyDescription)}
    unknown = [name for name in values if name not in known]
    if unknown:
        raise UnknownName("value of a policy", unknown[0][:60], known)
    try:
        return PolicyDescription(**{name: _read(name, value) for name, value in values.items()})
    except (TypeError, AttributeError, KeyError) as error:
        raise DesignError("policy", got=Unquoted(f"misstated: {error}"), allowed="what `learn` writes") from None


def _parse_object(text: str) -> dict[str, Any]:
    try:
        values = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError):
        values = None
    if not isinstance(values, dict):
        raise DesignError("policy", got=Unquoted("no JSON object"), allowed="the JSON file that `learn` writes")
    return values


def _read(name: str, value: Any) -> Any:
    """A value of JSON in the type of its field."""
    if name == "networks":
        return {str(key): Layers(**{**each, "sizes": tuple(each["sizes"])}) for key, each in dict(value).items()}
    if name == "stages":
        return tuple(Stage(**{key: _read_list(part) for key, part in each.items()}) for each in value)
    return dict(value) if name == "provenance" else _read_list(value)


def _read_list(value: Any) -> Any:
    """A list as a tuple, any other value as it is."""
    return tuple(value) if isinstance(value, list) else value


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON")


def _check_choice(name: str, value: object, known: tuple[str, ...]) -> None:
    if not (isinstance(value, str) and value in known):
        raise DesignError(name, got=value, allowed=", ".join(known))
