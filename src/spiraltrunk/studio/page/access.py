"""What viser's client lacks for the keyboard, for screen readers and for weak eyes."""

from __future__ import annotations

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
    [data-folder]:focus-visible, [role=slider]:focus-visible { outline: 3px solid #56B4E9; outline-offset: 2px; }`;
  document.head.append(style);
  const nameFolders = () => {
    for (const mark of document.querySelectorAll("svg.tabler-icon-chevron-down, svg.tabler-icon-chevron-up")) {
      const head = mark.parentElement, body = head.nextElementSibling;
      if (!body || head.tagName !== "DIV" || head.style.cursor !== "pointer") continue;
      head.setAttribute("aria-expanded", body.getAttribute("aria-hidden") !== "true");
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
    }
  };
  const nameSliders = () => {
    for (const label of document.querySelectorAll("label[for]")) {
      const root = document.getElementById(label.htmlFor);
      if (!root?.querySelector("[role=slider]")) continue;
      for (const part of root.parentElement.querySelectorAll("[role=slider], input[inputmode]"))
        if (part.getAttribute("aria-label") !== label.textContent) part.setAttribute("aria-label", label.textContent);
    }
  };
  let waits = false;
  const look = () => {
    if (waits) return;
    waits = true;
    setTimeout(() => { waits = false; nameFolders(); nameSliders(); }, 200);
  };
  const options = { subtree: true, childList: true, attributes: true, attributeFilter: ["aria-hidden"] };
  new MutationObserver(look).observe(document.body, options);
  look();
}
"""
"""Heads of folders take the focus and open by Enter or Space; sliders and number boxes have the name of their label;
labels, ends of sliders, tabs and notices have a contrast of 5 and more to the ground (viser's: 3.0
and more)."""


def open_access(client: ClientHandle) -> None:
    """Make all controls of a page reachable by keyboard, named and readable; those that come later as well."""
    run_script(client, _SCRIPT)
