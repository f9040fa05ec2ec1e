// Leaves of the viewer's client the scene alone, and its notes in the page's own variables. Purely cosmetic:
// if a later client names its parts otherwise, it merely looks like itself again.

import { onScheme, scheme } from "./theme.js";

const TOKENS = ["bg", "panel", "raised", "line", "ink", "dim", "faint", "accent"];

const SOFTWARE = "webgl-software-rendering"; // a note that stays until clicked, over the glider

const RULES = `
:root[data-mantine-color-scheme] {
  --mantine-color-body: var(--panel);
  --mantine-color-text: var(--ink);
  --mantine-color-dimmed: var(--dim);
  --mantine-color-default: var(--bg);
  --mantine-color-default-hover: var(--raised);
  --mantine-color-default-border: var(--line);
  --mantine-color-default-color: var(--ink);
  --mantine-color-placeholder: var(--faint);
}
:root[data-mantine-color-scheme="dark"] {
  --mantine-color-dark-4: var(--line);
  --mantine-color-dark-5: var(--raised);
  --mantine-color-dark-6: var(--bg);
  --mantine-color-dark-7: var(--panel);
}
/* Its control panel: the page has its own. It is told by its handles for resizing, and in a narrow frame, where it is a
   sheet at the bottom, by being fixed there; there its own style says how it is displayed. */
.mantine-Paper-root:is(:has(> [style*="-resize"]), [style*="position: fixed"]) { display: none !important; }
/* Clear of the page's buttons over the scene. */
.mantine-Notifications-root { margin-top: 76px; }
#${SOFTWARE} { display: none; }`;

function tokens() {
  const style = getComputedStyle(document.documentElement);
  return `:root { ${TOKENS.map((name) => `--${name}: ${style.getPropertyValue(`--${name}`)};`).join(" ")} }`;
}

// The server can only set one theme for all its viewers; the person's own preference is known here.
function followScheme(root) {
  const set = () => {
    if (root.getAttribute("data-mantine-color-scheme") !== scheme()) root.setAttribute("data-mantine-color-scheme", scheme());
  };
  set();
  new root.ownerDocument.defaultView.MutationObserver(set).observe(root, { attributeFilter: ["data-mantine-color-scheme"] });
  return set;
}

// Hidden at once by the rule above, and closed too, so that it keeps no place among other notes.
function closeSoftwareNote(doc) {
  const close = () => doc.querySelector(`#${SOFTWARE} button`)?.click();
  close();
  const seen = new doc.defaultView.MutationObserver(close);
  seen.observe(doc.body, { childList: true, subtree: true });
  doc.defaultView.setTimeout(() => seen.disconnect(), 10_000);
}

export function applySkin(doc) {
  try {
    const sheet = new doc.defaultView.CSSStyleSheet();
    const dress = () => sheet.replaceSync(tokens() + RULES);
    dress();
    doc.adoptedStyleSheets = [...doc.adoptedStyleSheets, sheet];
    closeSoftwareNote(doc);
    const set = followScheme(doc.documentElement);
    onScheme(() => {
      dress();
      set();
    });
  } catch {
    // An error page in the iframe: nothing to dress.
  }
}

// The client's outline of what the pointer is over says that it takes fog, but lacks what fog needs: with fog in the water
// each picture with it would break off half drawn.
export function mendOutlines(scene) {
  scene?.traverse(({ material }) => {
    for (const one of [material].flat()) if (one?.fog && one.uniforms && !one.uniforms.fogColor) one.fog = false;
  });
}
