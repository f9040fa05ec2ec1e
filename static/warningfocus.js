// From a stretch on the timeline to the warning in the list that it stands for.

import { $ } from "./dom.js";

export function focusWarning({ message }) {
  const found = [...$("warnings").querySelectorAll("summary")].find((node) => node.textContent === message);
  if (!found) return;
  found.parentElement.open = true;
  found.focus();
  found.scrollIntoView({ block: "nearest" });
}
