"""Controls of all parameters of a design, in folders."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, final

from spiraltrunk.design import GripperDesign, TrunkDesign
from spiraltrunk.design.edit import Rules, change_field, change_rules, read_field, read_rules
from spiraltrunk.design.materials import RIGID
from spiraltrunk.design.rules import M_MEANING, RANGES
from spiraltrunk.design.schema import Kind
from spiraltrunk.studio.design.fields import TYPED_DIGITS, ShownField, list_shown
from spiraltrunk.studio.page.controls import Choice, Slider, Switch, TextBox
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale

Vary = Callable[[TrunkDesign], TrunkDesign]
Change = Callable[[Vary], None]
"""Changes the design by a function of it, or raises the error of the design."""

GRIPPER = "Gripper at the tip"
"""Label of the switch of the gripper."""

_RULES = {
    "m": ("Ratio m", "", 1.0, M_MEANING[:1].upper() + M_MEANING[1:]),
    "delta_theta": ("Angle Δθ", "deg", math.pi / 180, "Angle per section; it moves to the nearest for whole sections"),
    "arm_radius": ("Arm radius", "mm", 1e-3, "Radius of the arm's last link, which section 1 matches"),
    "turns": ("Turns", "", 1.0, "Turns of the spiral; they move to the nearest that give whole sections"),
}  # fmt: skip
"""Label, unit, its size in SI and hint of each requirement of the paper's rules."""

_FOLDERS = (
    ("Spiral and sections", "spiral"), ("Joints", "joint"), ("Cables", "cable"), ("Masses", "mass"),
    ("Gripper", "gripper"), ("Housing and neck", "housing"), ("Arm", "arm"),
)  # fmt: skip

_FOLLOWING: dict[str, Callable[[TrunkDesign], float]] = {
    "mass.center_fraction": lambda design: design.solid.centroid / design.solid.length,
    "housing.mass": lambda design: design.housing.total_mass,
    "housing.neck_mass": lambda design: design.housing.total_neck_mass,
}
"""Value that a rule gives an optional number where the design has none."""


@final
class Parameters:
    """All controls of a design's parameters."""

    def __init__(self, page: Page, change: Change) -> None:
        self._page = page
        self._change = change
        self._writers: list[Callable[[TrunkDesign], None]] = []
        self._spare = GripperDesign()

    def build_rules(self, design: TrunkDesign) -> None:
        """Add the paper's rules, open."""
        with self._page.gui.add_folder("Rules of the paper"):
            for name in Rules._fields:
                self._add_rule(name, design)

    def build_parts(self, design: TrunkDesign) -> None:
        """Add the folders of the parts, closed."""
        for title, table in _FOLDERS:
            with self._page.gui.add_folder(title, expand_by_default=False):
                if table == "gripper":
                    self._add_gripper(design)
                if table == "cable":
                    self._add_cable_count(design)
                for field in list_shown(table):
                    self._add_field(field, design)

    def show(self, design: TrunkDesign) -> None:
        """Write a design into the controls."""
        for write in self._writers:
            write(design)

    def _add_rule(self, name: str, design: TrunkDesign) -> None:
        label, unit, size, hint = _RULES[name]
        allowed = RANGES[name].in_unit(size)
        least, most = (1.0, 89.0) if name == "delta_theta" else (allowed.least, allowed.most)
        step, digits = (0.05, 3) if name in ("m", "turns") else (0.5, 2 if unit == "deg" else 1)
        scale = Scale(
            label=label, unit=unit, least=least, most=most, step=step, digits=digits, typed_digits=TYPED_DIGITS,
            hint=hint,
        )  # fmt: skip

        def read(shown: TrunkDesign) -> float:
            return float(getattr(read_rules(shown), name) / size)

        def write(shown: TrunkDesign) -> None:
            slider.fit(read(shown))

        def find_change(given: float) -> str:
            """That another value holds than was given, which whole sections need."""
            design = self._page.design
            if math.isclose(read(design), given, abs_tol=0.5 * 10.0**-digits):
                return ""
            return f"{scale.tell_change(f'{given:g}', read(design))} ({design.n_section} sections)"

        def take(given: float) -> None:
            self._change(lambda old: change_rules(old, **{name: given * size}))
            slider.tell_later(lambda: find_change(given))

        slider = Slider(self._page, scale, read(design), take)
        write(design)
        self._writers.append(write)

    def _add_field(self, field: ShownField, design: TrunkDesign) -> None:
        if field.key.kind in (Kind.NUMBER, Kind.COUNT):
            self._add_slider(field, design)
        elif field.name in _OPTIONS and not (field.name == "arm.mount_site" and design.arm.is_file):
            self._add_choice(field, design)
        else:
            self._add_text(field, design)

    def _set(self, field: ShownField, value: Any) -> None:
        def vary(old: TrunkDesign) -> TrunkDesign:
            design = change_field(old, field.name, value)
            if field.name in ("arm.mount_site", "arm.home"):
                _check_arm(design)
            return design

        self._change(vary)

    def _add_slider(self, field: ShownField, design: TrunkDesign) -> None:
        switch = self._add_given(field, design) if field.is_optional else None
        scale = field.scale
        slider = Slider(self._page, scale, scale.least, lambda given: self._set(field, field.from_shown(given)))

        def write(shown: TrunkDesign) -> None:
            value = read_field(shown, field.name)
            is_there = value is not None
            if slider.handle.visible != is_there:
                slider.handle.visible = is_there
            if switch is not None:
                switch.set(is_there)
            if is_there:
                slider.fit(field.to_shown(value))

        write(design)
        self._writers.append(write)

    def _add_given(self, field: ShownField, design: TrunkDesign) -> Switch:
        """A switch of an optional value: on for a measured value, off for the value by its rule."""

        def take(is_given: bool) -> None:
            self._change(lambda old: change_field(old, field.name, _FOLLOWING[field.name](old) if is_given else None))

        is_given = read_field(design, field.name) is not None
        return Switch(self._page, f"{field.label}: measured", is_given, take, hint=_add_otherwise(field, "Off"))

    def _add_choice(self, field: ShownField, design: TrunkDesign) -> None:
        def find_options(shown: TrunkDesign) -> tuple[str, ...]:
            known, value = _OPTIONS[field.name](), read_field(shown, field.name)
            return known if value in known else (*known, value)

        value, options = read_field(design, field.name), find_options(design)
        choice = Choice(self._page, field.label, options, value, lambda given: self._set(field, given), hint=field.hint)

        def write(shown: TrunkDesign) -> None:
            value, wanted = read_field(shown, field.name), find_options(shown)
            if choice.options != wanted:
                choice.set_options(wanted)
            if choice.value != value:
                choice.set(value)

        self._writers.append(write)

    def _add_text(self, field: ShownField, design: TrunkDesign) -> None:
        hint = _add_otherwise(field, "Empty") if field.is_optional else field.hint
        if field.key.kind is Kind.NUMBERS:
            hint += " Numbers, separated by commas."
        box = TextBox(
            self._page, field.text, field.format(read_field(design, field.name)),
            lambda given: self._set(field, field.parse(given)), hint=hint, most=4000,
        )  # fmt: skip
        self._writers.append(lambda shown: box.set(field.format(read_field(shown, field.name))))

    def _add_gripper(self, design: TrunkDesign) -> None:
        self._spare = design.gripper or self._spare

        def take(is_there: bool) -> None:
            self._change(lambda old: change_gripper(old, self._spare if is_there else None))

        switch = Switch(self._page, GRIPPER, design.gripper is not None, take, hint="A trunk with or without fingers")

        def write(shown: TrunkDesign) -> None:
            switch.set(shown.gripper is not None)
            self._spare = shown.gripper or self._spare

        self._writers.append(write)

    def _add_cable_count(self, design: TrunkDesign) -> None:
        scale = Scale(label="Number of cables", unit="", least=2, most=12, step=1, hint="Evenly spaced from cable 1")

        def take(given: float) -> None:
            self._change(lambda old: space_cables(old, round(given)))

        slider = Slider(self._page, scale, design.n_cable, take)
        self._writers.append(lambda shown: slider.set(shown.n_cable))


def _add_otherwise(field: ShownField, without: str) -> str:
    """The hint of an optional field, and what holds ``without`` a value."""
    return f"{field.hint} {without}: {field.otherwise}."


def change_gripper(design: TrunkDesign, gripper: GripperDesign | None) -> TrunkDesign:
    """The design with another gripper, or none."""
    return replace(design, gripper=gripper)


def space_cables(design: TrunkDesign, count: int) -> TrunkDesign:
    """The design with so many cables, evenly spaced from the present cable 1."""
    first = design.cable.angles[0]
    angles = tuple(first + 2 * math.pi * i / count for i in range(count))
    return change_field(design, "cable.angles", angles)


def _list_arms() -> tuple[str, ...]:
    from spiraltrunk.sim.robot.arm import ARMS

    return tuple(ARMS)


def _list_sites() -> tuple[str, ...]:
    from spiraltrunk.sim.robot.arm import FLANGE

    return (FLANGE,)


def _check_arm(design: TrunkDesign) -> None:
    from spiraltrunk.sim.robot.arm import check_arm

    check_arm(design.arm)


_OPTIONS: dict[str, Callable[[], tuple[str, ...]]] = {
    "housing.material": lambda: tuple(RIGID), "arm.model": _list_arms, "arm.mount_site": _list_sites
}  # fmt: skip
"""What can be chosen for a text of a design; sites are those of the described arms."""
