"""Number boxes that are left without a number show the value that holds."""

from __future__ import annotations

from viser import ClientHandle

from spiraltrunk.studio.page.identity import run_script

_SCRIPT = """
if (!window.spiraltrunkNumberBoxes) {
  window.spiraltrunkNumberBoxes = true;
  const write = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const isNumber = (text) => text.trim() !== "" && Number.isFinite(Number(text));
  const restore = (box) => {
    const held = box.closest(":has([role=slider])")?.querySelector("[role=slider]")?.getAttribute("aria-valuenow");
    if (!held || isNumber(box.value)) return;
    write.call(box, held);
    box.dispatchEvent(new Event("input", { bubbles: true }));
  };
  window.addEventListener("focusout", (event) => {
    if (event.target.matches?.("input[inputmode]")) setTimeout(() => restore(event.target));
  });
}
"""
"""Viser's client sends no message for a box that is emptied, or holds a sign alone, and leaves it so. The slider beside
it keeps the value."""


def open_number_boxes(client: ClientHandle) -> None:
    """Let each number box of a page go back to its value where it is left without a number."""
    run_script(client, _SCRIPT)
