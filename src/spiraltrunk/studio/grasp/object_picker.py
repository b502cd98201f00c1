"""Picker of the object: of the catalogue, by its measures, or from a file of the person."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.errors import DesignError, ModelError, StudioError
from spiraltrunk.sim.objects.catalogue import CATALOGUE, DEFAULT_OBJECT, SOLIDS, ObjectSpec, parse_object
from spiraltrunk.sim.objects.meshes.mesh_file import AXES, COLLIDES, UNITS
from spiraltrunk.sim.user_files.regular_file import FILE_MOST
from spiraltrunk.studio.grasp.jobs import read_upload
from spiraltrunk.studio.page.buttons import add_upload
from spiraltrunk.studio.page.controls import Choice, Slider
from spiraltrunk.studio.page.markdown import escape_markdown
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.page.scale import Scale

BY_MEASURES = "by its measures"
FROM_FILE = "from a file (STL, OBJ)"
FORMS = ("stl", "obj")
"""Endings of files that can be read."""

GUESS = "guess"
"""Unit of a file that does not state it."""


def _scale(label: str, hint: str) -> Scale:
    """Scale of a length."""
    return Scale(label=label, unit="mm", least=5.0, most=400.0, step=0.5, hint=hint)


_MEASURES = {
    "diameter_mm": _scale("Diameter", "Diameter of the solid's round foot"),
    "height_mm": _scale("Height", "Extent along the solid's axis"),
    "x_mm": _scale("Depth x", "Extent of the foot along x"),
    "y_mm": _scale("Width y", "Extent of the foot along y"),
    "z_mm": _scale("Height z", "Extent upwards"),
    "outer_mm": _scale("Outer diameter", "Outer diameter of the ring, more than two tubes"),
    "tube_mm": _scale("Tube", "Diameter of the ring's tube"),
    "neck_mm": _scale("Neck", "Diameter of the bottle's neck, less than the bottle's"),
    "mass_g": Scale(label="Mass", unit="g", least=1.0, most=5000.0, step=1.0, hint="Mass, spread evenly"),
}
"""Measures by their names in `parse_object`."""

_FIRST = {
    "diameter_mm": 60.0, "height_mm": 200.0, "x_mm": 60.0, "y_mm": 60.0, "z_mm": 200.0, "outer_mm": 90.0,
    "tube_mm": 15.0, "neck_mm": 30.0, "mass_g": 250.0,
}  # fmt: skip

_OPTIONS = {
    "unit= states it": "Unit states it", "mass_g": "Mass", "collide=hull": "Touched at hull",
    "collide=parts": "Touched at parts", "; pose= says otherwise": "",
    "; an OBJ is given by obj:path=": ", in a file that ends in .stl",
    "; an STL is given by stl:path=": ", in a file that ends in .obj",
}  # fmt: skip
"""Options of a file in the texts of its reader, and what the page has in their place."""

_HINT = "What is to be grasped; the numbers are widths in mm"

_MOST = f"at most {FILE_MOST // 1_000_000} MB"

_EMPTY = f"No file yet: drop or choose an STL or OBJ file of a closed surface, {_MOST}."


@final
@dataclass(frozen=True, kw_only=True)
class Upload:
    """A file as it arrived."""

    name: str
    """Its name as the browser gave it, for texts alone."""
    form: str
    """stl or obj."""
    content: bytes
    """Its content."""


@final
class ObjectPicker:
    """Controls of the object; ``on_change`` is called where another one was picked."""

    def __init__(self, page: Page, on_change: Callable[[], None]) -> None:
        self._page = page
        self._on_change = on_change
        self._upload: Upload | None = None
        self._shape: ObjectSpec | None = None
        self._reading: Any = None
        options = (*CATALOGUE, BY_MEASURES, FROM_FILE)
        self.source = Choice(page, "Object", options, DEFAULT_OBJECT, self._take_choice, hint=_HINT)
        self._measures = page.gui.add_folder("Measures of the object", visible=False)
        self._file = page.gui.add_folder("File of the object", visible=False)
        with self._measures:
            self._build_measures()
        with self._file:
            self._build_file()
        self._lay_out()

    def read(self) -> tuple[str, ObjectSpec]:
        """Name and shape of the picked object.

        Raises:
            ModelError: for measures that make no solid, and where the file is missing or not read yet.
        """
        if self.source.value == BY_MEASURES:
            name = self._format_measures()
            try:
                return name, parse_object(name)
            except DesignError as error:
                raise ModelError(_name_controls(str(error))) from None
        if self.source.value != FROM_FILE:
            return self.source.value, parse_object(self.source.value)
        if self._shape is None or self._upload is None:
            raise ModelError("the object's file is missing: choose an STL or OBJ file, or another object")
        return self._upload.name, self._shape

    @property
    def option(self) -> str:
        """What `--object` of the command line takes for it."""
        if self.source.value == BY_MEASURES:
            return self._format_measures()
        if self.source.value != FROM_FILE or self._upload is None:
            return self.source.value
        more = "".join(f",{name}={value}" for name, value in self._read_file_options().items())
        return f"{self._upload.form}:path=FILE,mass_g={self._mass.value:g}{more}"

    def read_settings(self) -> dict[str, Any]:
        """Settings that come back; a file and what was said of it do not."""
        measures = {name: slider.value for name, slider in self._sliders.items()}
        return {"object": self.source.value, "solid": self._solid.value, "measures": measures}

    def apply_settings(self, settings: dict[str, Any]) -> None:
        """Take settings of an earlier page."""
        self.source.set(str(settings.get("object")))
        self._solid.set(str(settings.get("solid")))
        measures = settings.get("measures")
        for name, value in measures.items() if isinstance(measures, dict) else ():
            if name in self._sliders and isinstance(value, int | float):
                self._sliders[name].set(value)
        self._lay_out()

    def _build_measures(self) -> None:
        page = self._page
        self._solid = Choice(page, "Solid", tuple(SOLIDS), "cylinder", self._take_choice, hint="Kind of solid")
        self._sliders = {
            name: Slider(page, scale, _FIRST[name], lambda _: self._on_change()) for name, scale in _MEASURES.items()
        }

    def _build_file(self) -> None:
        page, again = self._page, lambda _: self._read_file()
        hint = f"STL or OBJ of one closed surface, {_MOST}; it stays on this computer"
        add_upload(page, "Choose a file", self._take_file, hint=hint, most=FILE_MOST, kinds=".stl,.obj")
        self._notes: Any = page.gui.add_markdown(_EMPTY)
        self._mass = Slider(page, _MEASURES["mass_g"], 250.0, again)
        units = (GUESS, *UNITS)
        self._unit = Choice(page, "Unit", units, GUESS, again, hint="Unit of the file's coordinates")
        self._axis = Choice(page, "Axis", AXES, "longest", again, hint="Direction that becomes the object's axis")
        hint = "Touched at its convex hull, or at convex parts, which keep hollows"
        self._collide = Choice(page, "Touched at", COLLIDES, "hull", again, hint=hint)

    def _format_measures(self) -> str:
        solid = self._solid.value
        return f"{solid}:" + ",".join(f"{name}={self._sliders[name].value:g}" for name in SOLIDS[solid])

    def _lay_out(self) -> None:
        """Show the controls of the chosen source and solid alone."""
        self._measures.visible = self.source.value == BY_MEASURES
        self._file.visible = self.source.value == FROM_FILE
        for name, slider in self._sliders.items():
            slider.handle.visible = name in SOLIDS[self._solid.value]

    def _take_choice(self, _: str) -> None:
        """Another source or solid was chosen."""
        self._lay_out()
        self._on_change()

    def _take_file(self, name: str, content: bytes) -> None:
        """Take what was uploaded; its name serves texts alone.

        Raises:
            StudioError: for a file of another kind.
        """
        form = name.rpartition(".")[2].lower()
        if form not in FORMS:
            raise StudioError(f"the file {name!r} was given; allowed: a file that ends in .stl or .obj")
        self._upload = Upload(name=name, form=form, content=content)
        self._read_file()

    def _read_file_options(self) -> dict[str, str]:
        unit = {} if self._unit.value == GUESS else {"unit": self._unit.value}
        return {**unit, "axis": self._axis.value, "collide": self._collide.value}

    def _read_file(self) -> None:
        if self._upload is None:
            return
        if self._reading is not None:
            self._reading.stop()
        self._shape, upload = None, self._upload
        self._notes.content = f"Reading *{escape_markdown(upload.name)}* ..."
        mass = self._mass.value / 1000.0
        self._reading = self._page.start(
            read_upload, upload.content, upload.form, mass, self._read_file_options(),
            on_report=lambda _: None, on_end=lambda shape, reason: self._end_reading(upload, shape, reason),
        )  # fmt: skip

    def _end_reading(self, upload: Upload, shape: ObjectSpec | None, reason: str | None) -> None:
        if upload is not self._upload or reason == "stopped":
            return
        if shape is None:
            reason = name_upload(str(reason), upload.name)
            self._notes.content = f"*{escape_markdown(upload.name)}* cannot be used: {escape_markdown(reason)}"
            self._page.notice(f"{upload.name}: {reason}", "refusal")
            return
        self._page.clear_refusal()
        self._shape = shape
        size = " x ".join(f"{1e3 * extent:.0f}" for extent in shape.size)
        warnings = "".join(f"\n- {escape_markdown(name_upload(warning, upload.name))}" for warning in shape.warnings)
        self._notes.content = f"*{escape_markdown(upload.name)}*: {size} mm, {1e3 * shape.mass:g} g{warnings}"
        self._on_change()


def name_upload(text: str, name: str) -> str:
    """A text in which the file of `read_upload` has the name that the person knows it by, and options their labels."""
    text = re.sub(rf"[^\s']*\bobject\.({'|'.join(FORMS)})\b", lambda _: name, text)
    text = re.sub(rf"\b({'|'.join(FORMS)}):path (is|was)\b", r"the file \2", text)
    for option, label in _OPTIONS.items():
        text = text.replace(option, label)
    return text


def _name_controls(text: str) -> str:
    """A text in which the measures of `parse_object` have the labels of their controls."""
    return re.sub(r"\bobject\.(\w+)", lambda found: _label(found[1]), text)


def _label(measure: str) -> str:
    return _MEASURES[measure].text if measure in _MEASURES else measure
