// Opens the 3D view before the page's modules are there: a plain script beside its frame. `?fixedDpr=0.5` is passed on.
// The list of presets runs it too, to have found out how this machine draws before a studio is opened.
{
  const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
  // What the client comes down to by itself where pictures are slow; each step on its way there stops the page for long.
  const COARSE = 0.75;
  const KEY = "glider-studio.drawn-in-software";

  // Null without WebGL 2, which the client needs.
  function nameOfRenderer() {
    const gl = document.createElement("canvas").getContext("webgl2");
    if (!gl) return null;
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    gl.getExtension("WEBGL_lose_context")?.loseContext();
    return name;
  }

  function kept(value) {
    try {
      if (value !== undefined) sessionStorage.setItem(KEY, value);
      return sessionStorage.getItem(KEY);
    } catch {
      return null; // a browser that keeps nothing for pages
    }
  }

  // "true" or "false", or null where nothing can be drawn: that is not kept, as the next page may find it mended.
  function drawnInSoftware() {
    const known = kept();
    if (known) return known;
    const name = nameOfRenderer();
    if (name === null) return null;
    const found = String(SOFTWARE.test(name));
    kept(found);
    return found;
  }

  function open(view) {
    const drawn = drawnInSoftware();
    if (!view) return;
    if (drawn === null) {
      view.hidden = true;
      document.getElementById("no-view").hidden = false;
      return;
    }
    const given = Number(new URLSearchParams(location.search).get("fixedDpr"));
    const ratio = given > 0 ? given : drawn === "true" ? COARSE * devicePixelRatio : 0;
    view.src = ratio > 0 ? `view/?fixedDpr=${ratio}` : "view/";
  }

  open(document.getElementById("view"));
}
