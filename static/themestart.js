// Chooses light or dark before the first paint: a plain script in the head, since modules run too late for that.
{
  let chosen = null;
  try {
    chosen = localStorage.getItem("glider-studio.theme");
  } catch {
    // A browser that keeps nothing for pages: its own preference holds.
  }
  const own = matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark";
  document.documentElement.dataset.theme = chosen === "light" || chosen === "dark" ? chosen : own;
}
