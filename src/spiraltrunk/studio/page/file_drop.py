"""Files that are dropped onto a page: given to the upload button that takes them, or told to have no place."""

from __future__ import annotations

import json

from viser import ClientHandle

from spiraltrunk.studio.page.identity import run_script

_SCRIPT = """
if (!window.spiraltrunkDrop) {
  window.spiraltrunkDrop = true;
  const hasFiles = (event) => [...(event.dataTransfer?.types ?? [])].includes("Files");
  const listInputs = () => [...document.querySelectorAll("input[type=file]")].filter((one) => one.accept);
  const takes = (input, name) => input.accept.split(",").some((ending) => name.toLowerCase().endsWith(ending.trim()));
  const tell = (text) => {
    document.getElementById("spiraltrunk-drop-note")?.remove();
    const note = document.createElement("div");
    note.id = "spiraltrunk-drop-note";
    note.setAttribute("role", "alert");
    note.textContent = text;
    note.style.cssText = "position: fixed; left: 18px; bottom: 18px; z-index: 9999; max-width: 420px; padding: 12px;"
      + "background: #5b6168; color: white; font: 14px sans-serif; border-left: 6px solid #E69F00";
    document.body.append(note);
    setTimeout(() => note.remove(), 8000);
  };
  window.addEventListener("dragover", (event) => { if (hasFiles(event)) event.preventDefault(); });
  window.addEventListener("drop", (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    const files = event.dataTransfer.files, inputs = listInputs();
    if (files.length !== 1) return tell(`${files.length} files were dropped; allowed: one at a time`);
    const input = inputs.find((one) => takes(one, files[0].name));
    if (!input) {
      const place = Object.entries({places}).find(([ending]) => files[0].name.toLowerCase().endsWith(ending));
      if (place) return tell(`${files[0].name} has no place here; ${place[1]} takes it`);
      const endings = inputs.map((one) => one.accept.replaceAll(",", ", ")).join(", ");
      return tell(`${files[0].name} has no place here; ${endings ? "allowed: " + endings : "this view takes no file"}`);
    }
    const given = new DataTransfer();
    given.items.add(files[0]);
    input.files = given.files;
    input.dispatchEvent(new Event("change", { bubbles: true }));
  });
}
"""
"""Without it, a file that is dropped takes the place of the page, which is closed then. Only buttons of the tab that is
shown are in the document."""


_MESH = "the tab Grasp, with an object from a file,"

_PLACES = {
    ".toml": "the tab Design (a design) or Measure (a protocol)", ".csv": "the tab Measure", ".c3d": "the tab Measure",
    ".stl": _MESH, ".obj": _MESH,
}  # fmt: skip
"""What takes a file of each ending."""


def open_drop(client: ClientHandle) -> None:
    """Let files be dropped onto a page."""
    run_script(client, _SCRIPT.replace("{places}", json.dumps(_PLACES)))
