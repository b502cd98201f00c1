"""HTML head of the page: what is added to that of viser's client."""

from __future__ import annotations

_SCRIPT = """
(() => {
  const genuine = HTMLCanvasElement.prototype.getContext;
  let isSoftware = null;
  const ask = () => {
    const gl = genuine.call(document.createElement("canvas"), "webgl2");
    const info = gl?.getExtension("WEBGL_debug_renderer_info");
    const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
    gl?.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  };
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    if (kind === "webgl2") {
      isSoftware ??= ask();
      if (isSoftware) options = { ...options, antialias: false };
    }
    return genuine.call(this, kind, options);
  };
})();
"""
"""Where the browser draws by software, smooth edges take more than half of the time of a picture: it goes without."""

_HEAD = f"<title>spiraltrunk studio</title><script>{_SCRIPT}</script>".encode()

_PLACE = b"<title>Viser</title>"


def add_head(page: bytes) -> bytes:
    """The HTML of viser's client with our head."""
    return page.replace(_PLACE, _HEAD, 1)
