"""Colours of the page's controls."""

from __future__ import annotations

from viser import ClientHandle, _messages

BRAND = (0, 114, 178)
"""Colour of buttons and sliders: blue of the palette of Okabe and Ito; white letters on it have a contrast of 5.2."""

GRAY = (91, 97, 104)
"""Colour of buttons that lead away; white letters on it have a contrast of 6.2."""

_SHADES = (-0.93, -0.84, -0.7, -0.55, -0.42, -0.2, 0.0, 0.12, 0.0, 0.25)
"""Shades that the client takes by their numbers, as shares of black, or of white where negative: 6 for buttons on light
ground, 8 on dark ground, 4 for letters on dark ground."""


def set_theme(client: ClientHandle, *, is_dark: bool) -> None:
    """Set the theme of a page; the palette of viser's own function has black letters on its buttons."""
    client.gui._websock_interface.queue_message(
        _messages.ThemeConfigurationMessage(
            titlebar_content=None,
            control_layout="floating",
            control_width="large",
            show_logo=False,
            show_share_button=False,
            dark_mode=is_dark,
            colors=_build_palette(),
        )
    )


def _build_palette() -> tuple[str, str, str, str, str, str, str, str, str, str]:
    shades = []
    for share in _SHADES:
        end = 255 if share < 0 else 0
        channels = (round(each + abs(share) * (end - each)) for each in BRAND)
        shades.append("#{:02x}{:02x}{:02x}".format(*channels))
    a, b, c, d, e, f, g, h, i, j = shades
    return a, b, c, d, e, f, g, h, i, j
