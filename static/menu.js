// Menus that open under a button: closed by a click elsewhere, by Escape, and by choosing what is done with it.

export function connectMenu(menu) {
  const summary = menu.querySelector("summary");
  const close = () => menu.removeAttribute("open");
  document.addEventListener("pointerdown", (event) => menu.contains(event.target) || close());
  // A click into the 3D view is an event of another document: what is heard here is that the focus went there.
  window.addEventListener("blur", () => document.activeElement?.tagName === "IFRAME" && close());
  document.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !menu.open || document.querySelector("dialog[open]")) return;
    event.preventDefault();
    close();
    summary.focus();
  });
  menu.addEventListener("click", (event) => {
    const item = event.target.closest("a, [data-closes]");
    if (!item) return;
    if (item.hasAttribute("aria-disabled")) event.preventDefault();
    else close();
  });
  return close;
}
