"""Buttons, and buttons by which a person sends a file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from spiraltrunk.errors import StudioError
from spiraltrunk.studio.page.page import Page


def add_button(page: Page, label: str, act: Callable[[], None], *, hint: str, **options: Any) -> Any:
    """Add a button whose act runs in the page's thread; further clicks while it waits count once."""
    handle = page.gui.add_button(label, hint=hint, **options)

    def press() -> None:
        page.clear_refusal()
        act()

    handle.on_click(lambda _: page.take(f"button {handle._impl.uuid}", press))
    return handle


def add_upload(page: Page, label: str, act: Callable[[str, bytes], None], *, hint: str, most: int, kinds: str) -> Any:
    """Add a button by which the person sends a file; ``act`` gets its name, which is no path, and its content.

    Args:
        page: the page.
        label: label of the button.
        act: called in the page's thread with each file.
        hint: one line that explains it.
        most: largest size [bytes]; a larger file is told and left.
        kinds: endings that the browser offers, such as ".toml".
    """
    handle = page.gui.add_upload_button(label, hint=hint, mime_type=kinds)

    def take() -> None:
        sent = handle.value
        if len(sent.content) > most:
            raise StudioError(f"{clean_name(sent.name)} has {len(sent.content)} bytes; allowed: {most}")
        act(clean_name(sent.name), sent.content)

    handle.on_upload(lambda _: page.take(f"upload {handle._impl.uuid}", take))
    return handle


def clean_name(name: str) -> str:
    """A file's name for a text, without folders and of letters, digits, points, dashes and underscores alone."""
    kept = "".join(each if each.isalnum() or each in "._-" else "_" for each in name.replace("\\", "/").split("/")[-1])
    return kept[-80:].lstrip(".") or "file"
