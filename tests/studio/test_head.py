"""The head that our page has beside viser's client."""

import pytest

from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.server.head import add_head

CONTEXT = """() => {
  const canvas = document.querySelector("canvas");
  const gl = canvas.getContext("webgl2");
  return [gl.getContextAttributes().antialias, gl.getParameter(gl.getExtension("WEBGL_debug_renderer_info")
    .UNMASKED_RENDERER_WEBGL)];
}"""


class PlainTab:
    name = title = "plain"

    def __init__(self, page: Page) -> None:
        pass

    def build(self):
        pass

    def show(self):
        pass

    def hide(self):
        pass

    def read_settings(self):
        return {}

    def apply_settings(self, settings):
        pass

    def close(self):
        pass


def test_the_head_takes_the_place_of_the_title_and_nothing_else():
    page = b"<html><head><title>Viser</title></head><body>Viser</body></html>"
    given = add_head(page)
    assert b"<title>spiraltrunk studio</title>" in given
    before, _, after = page.partition(b"<title>Viser</title>")
    assert given.startswith(before)
    assert given.endswith(after)


@pytest.mark.slow
def test_software_draws_without_smoothing(studio, open_page):
    page = open_page(studio([PlainTab]))
    smoothed, renderer = page.evaluate(CONTEXT)
    if "swiftshader" not in renderer.lower():
        pytest.skip(f"this browser draws by {renderer}")
    assert smoothed is False
