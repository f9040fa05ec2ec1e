// Opens the 3D view before the page's modules are there: a plain script beside its frame. `?fixedDpr=0.5` is passed on.
// The list of presets runs it too, to have found out how this machine draws before a studio is opened.
{
  const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;
  // What the client comes down to by itself where pictures are slow; each step on its way there stops the page for long.
  const COARSE = 0.75;
  const KEY = "glider-studio.drawn-in-software";

  function nameOfRenderer() {
    const gl = document.createElement("canvas").getContext("webgl");
    if (!gl) return ""; // the client says so
    const info = gl.getExtension("WEBGL_debug_renderer_info");
    const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    gl.getExtension("WEBGL_lose_context")?.loseContext();
    return name;
  }

  function drawnInSoftware() {
    try {
      const known = sessionStorage.getItem(KEY) ?? String(SOFTWARE.test(nameOfRenderer()));
      sessionStorage.setItem(KEY, known);
      return known === "true";
    } catch {
      return SOFTWARE.test(nameOfRenderer()); // a browser that keeps nothing for pages
    }
  }

  const given = Number(new URLSearchParams(location.search).get("fixedDpr"));
  const ratio = given > 0 ? given : drawnInSoftware() ? COARSE * devicePixelRatio : 0;
  const view = document.getElementById("view");
  if (view) view.src = ratio > 0 ? `view/?fixedDpr=${ratio}` : "view/";
}
