"""Number boxes take what is typed when it is complete: by Enter, or when the box is left."""

from __future__ import annotations

from viser import ClientHandle

from spiraltrunk.studio.page.identity import run_script

_SCRIPT = r"""
if (!window.spiraltrunkNumberBoxes) {
  window.spiraltrunkNumberBoxes = true;
  const write = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const edits = new WeakMap();
  const isBox = (target) => Boolean(target.matches?.("input[inputmode]") && findSlider(target));
  const findSlider = (box) => box.closest(":has([role=slider])")?.querySelector("[role=slider]");
  const begin = (box) => {
    const edit = { shown: box.value, property: Object.getOwnPropertyDescriptor(box, "value") };
    edits.set(box, edit);
    if (edit.property)
      Object.defineProperty(box, "value", {
        configurable: true, get: edit.property.get,
        set: (text) => { if (`${text}` !== box.value) edit.shown = `${text}`; },
      });
  };
  const end = (box) => {
    const edit = edits.get(box), typed = box.value.trim();
    edits.delete(box);
    if (edit.property) Object.defineProperty(box, "value", edit.property);
    box.value = edit.shown;
    return typed === edit.shown ? "" : typed;
  };
  const read = (text) => {
    const plain = text.replace("\u2212", "-");
    return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
  };
  const markAll = (box) => {
    for (const [name, value] of [["selectionStart", 0], ["selectionEnd", box.value.length]])
      Object.defineProperty(box, name, { configurable: true, value });
    box.dispatchEvent(new KeyboardEvent("keydown", { key: "Unidentified", bubbles: true }));
    delete box.selectionStart;
    delete box.selectionEnd;
  };
  const put = (box, text) => {
    markAll(box);
    write.call(box, text);
    box.dispatchEvent(new Event("input", { bubbles: true }));
  };
  const sendText = (slider, typed) => {
    const uuid = slider.closest("[id]:not([role=slider])")?.id;
    window.__viserMutable?.sendMessage({ type: "GuiUpdateMessage", uuid, updates: { value: typed } });
  };
  const commit = (box) => {
    const typed = edits.has(box) ? end(box) : "";
    if (!typed) return true;
    const slider = findSlider(box), value = read(typed);
    const [least, most] = ["aria-valuemin", "aria-valuemax"].map((name) => Number(slider.getAttribute(name)));
    if (!(value >= least && value <= most)) {
      sendText(slider, typed);
      return false;
    }
    put(box, value.toLocaleString("en-US", { useGrouping: false, maximumFractionDigits: 20 }));
    const rounded = value.toFixed((box.value.split(".")[1] ?? "").length);
    if (Number(box.value) !== value && box.value !== rounded) put(box, rounded);
    if (Number(box.value) !== value) sendText(slider, typed);
    return true;
  };
  window.addEventListener("beforeinput", (event) => {
    if (event.isTrusted && isBox(event.target) && !edits.has(event.target)) begin(event.target);
  }, true);
  window.addEventListener("input", (event) => {
    if (event.isTrusted && edits.has(event.target)) event.stopImmediatePropagation();
  }, true);
  window.addEventListener("keydown", (event) => {
    if (!edits.has(event.target)) return;
    if (event.key === "Escape") end(event.target);
    else if (event.key === "Enter") commit(event.target);
    else if (["ArrowUp", "ArrowDown"].includes(event.key) && !commit(event.target)) {
      event.preventDefault();
      event.stopImmediatePropagation();
    }
  }, true);
  window.addEventListener("change", (event) => {
    if (!event.isTrusted || !edits.has(event.target)) return;
    event.stopImmediatePropagation();
    commit(event.target);
  }, true);
  window.addEventListener("focusout", (event) => { commit(event.target); }, true);
}
"""
"""Viser's client sends each keystroke: on the way to 40 also 4, and 12 for 1e2, whose e it leaves out. What is typed is
held back here, so that its client sees the complete number alone. What its client writes into the box meanwhile is kept
until then; it also writes the box's own text, to move the caret. What is no number of the slider's range is sent as the
text that was typed, which the server refuses in words; of a number that the box rounds, it tells so. Escape gives the
value before. The arrow keys first take what was typed, and step from there. Viser's client finds what has changed from
what was selected at the last key: it is shown all of the text as selected before a number takes its place."""


def open_number_boxes(client: ClientHandle) -> None:
    """Let each number box of a page send its value by Enter or when it is left."""
    run_script(client, _SCRIPT)
