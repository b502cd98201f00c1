"""What viser's client lacks for the keyboard, for screen readers and for weak eyes, and room for its numbers."""

from __future__ import annotations

import json

from viser import ClientHandle

from spiraltrunk.studio.page.identity import run_script

_SCRIPT = """
if (!document.getElementById("spiraltrunk-access")) {
  const style = document.createElement("style");
  style.id = "spiraltrunk-access";
  style.textContent = `
    [data-mantine-color-scheme=light] { --mantine-color-dimmed: #5b6168 !important; }
    [data-mantine-color-scheme=dark] { --mantine-color-dimmed: #adb1b6 !important; }
    [role=tab][aria-selected=false] { color: var(--mantine-color-dimmed) !important; opacity: 1 !important; }
    [data-mantine-color-scheme=dark] [role=tab][aria-selected=true] { color: #56B4E9 !important;
      box-shadow: inset 0 -2px 0 0 #56B4E9 !important; }
    .mantine-Slider-markLabel, .mantine-Notification-description { color: var(--mantine-color-dimmed) !important; }
    .mantine-Slider-markLabel { transform: translate(-50%, 0.2rem) !important; }
    :has(> .mantine-Slider-root) > .mantine-NumberInput-root { width: 4.3rem !important; flex: none; }
    html { overflow: hidden; }
    body { position: fixed; inset: 0; overflow: clip; }
    .mantine-Notifications-root { max-height: calc(100% - 2em); overflow-y: auto; }
    .mantine-ScrollArea-content { box-sizing: border-box; padding-right: 5px; }
    [data-folder]:focus-visible, [role=slider]:focus-visible, input:focus-visible {
      outline: 3px solid #56B4E9 !important; outline-offset: 2px; }`;
  document.head.append(style);
  const read = () => {
    try { return JSON.parse(sessionStorage.getItem("spiraltrunk-folders")) || {}; } catch (error) { return {}; }
  };
  const keep = (name, isOpen) => {
    const kept = read();
    kept[name] = isOpen;
    try { sessionStorage.setItem("spiraltrunk-folders", JSON.stringify(kept)); } catch (error) {}
  };
  const isOpen = (body) => body.getAttribute("aria-hidden") !== "true";
  const path = (head) => {
    const names = [head.textContent];
    for (let part = head.parentElement; part; part = part.parentElement)
      if (part.previousElementSibling?.dataset.folder) names.unshift(part.previousElementSibling.textContent);
    return names.join("/");
  };
  const nameFolders = () => {
    for (const mark of document.querySelectorAll("svg.tabler-icon-chevron-down, svg.tabler-icon-chevron-up")) {
      const head = mark.parentElement, body = head.nextElementSibling;
      if (!body || head.tagName !== "DIV" || head.style.cursor !== "pointer") continue;
      head.setAttribute("aria-expanded", isOpen(body));
      if (head.dataset.folder) continue;
      head.dataset.folder = "true";
      head.tabIndex = 0;
      head.setAttribute("role", "button");
      head.setAttribute("aria-label", `${head.textContent} (folder)`);
      head.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        head.click();
      });
      const name = path(head);
      const before = read()[name];
      if (before !== undefined && before !== isOpen(body)) head.click();
      head.addEventListener("click", () => keep(name, !isOpen(body)));
    }
  };
  const nameBoxes = () => {
    for (const label of document.querySelectorAll("label[for]")) {
      const root = document.getElementById(label.htmlFor);
      const box = root ? null : label.closest(".mantine-Flex-root")?.querySelector("input");
      box?.setAttribute("aria-label", label.textContent);
      if (!root?.querySelector("[role=slider]")) continue;
      for (const part of root.parentElement.querySelectorAll("[role=slider], input[inputmode]"))
        if (part.getAttribute("aria-label") !== label.textContent) part.setAttribute("aria-label", label.textContent);
    }
  };
  const icons = {icons};
  const nameIcons = () => {
    for (const [icon, name] of Object.entries(icons))
      for (const one of document.querySelectorAll(`button:has(> * > svg.${icon}), button:has(> svg.${icon})`))
        one.setAttribute("aria-label", name);
    for (const one of document.querySelectorAll(".mantine-Notification-closeButton"))
      one.setAttribute("aria-label", "Close the notice");
    for (const one of document.querySelectorAll(".mantine-Notification-root"))
      if (one.textContent.endsWith("File uploaded successfully.")) one.style.display = "none";
  };
  document.body.addEventListener("keydown", (event) => {
    if (event.code.startsWith("Arrow") && event.target.closest("[role=slider], [role=tab]")) event.stopPropagation();
  });
  const settled = new WeakMap();
  const settlePlots = () => {
    for (const {chart} of Object.values(window.__viserTestpoints?.uplots ?? {})) {
      if (!chart?.width || settled.get(chart) === chart.width) continue;
      settled.set(chart, chart.width);
      chart.redraw(false, true);
    }
  };
  document.addEventListener("keydown", (event) => {
    const isKey = event.altKey ? /^Digit[1-9]$/.test(event.code) : event.ctrlKey && event.code === "KeyK";
    if (!isKey || !event.target.closest?.("input, textarea, select")) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    document.activeElement.blur();
    const { key, code, altKey, ctrlKey, metaKey, shiftKey } = event;
    const again = { key, code, altKey, ctrlKey, metaKey, shiftKey, bubbles: true, cancelable: true };
    document.body.dispatchEvent(new KeyboardEvent("keydown", again));
  }, true);
  let waits = false;
  const look = () => {
    if (waits) return;
    waits = true;
    setTimeout(() => { waits = false; nameFolders(); nameBoxes(); nameIcons(); settlePlots(); }, 200);
  };
  const options = { subtree: true, childList: true, attributes: true, attributeFilter: ["aria-hidden"] };
  new MutationObserver(look).observe(document.body, options);
  look();
}
"""
"""Heads of folders take the focus and open by Enter or Space, and a folder that was opened or closed is found so after
another tab or a reload; sliders, boxes and viser's icons have a name; labels, ends of sliders, tabs and notices
have a contrast of 5 and more to the ground (viser's: 3.0 and more). A plot is laid out without a width first, and loses
an axis where data arrive before it has one: its axes are computed again. The keys of tabs and commands also hold where
a box has the focus, which viser leaves to it; the arrow keys of a slider or a tab do not turn the scene. The page does
not scroll, however many notices stand on it, and the scroll bar of the panel covers none of its controls. Viser tells
that a file has arrived, and again whenever its button is shown anew; whether it was taken is told by our notices."""

_ICONS = {
    "tabler-icon-list-search": "Commands (Ctrl+K)", "tabler-icon-adjustments": "Connection, view and scene tree",
    "tabler-icon-arrow-back": "Back to the tabs",
}  # fmt: skip
"""Names of viser's buttons that show an icon alone."""


def open_access(client: ClientHandle) -> None:
    """Make all controls of a page reachable by keyboard, named and readable; those that come later as well."""
    run_script(client, _SCRIPT.replace("{icons}", json.dumps(_ICONS)))
