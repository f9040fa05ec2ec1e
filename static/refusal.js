// Why the server refused what was typed, in the form where it was typed.

import { el } from "./dom.js";
import { problemNodes } from "./problem.js";

export const refusalBox = (testid) => el("div", { class: "box bad", role: "alert", hidden: true, "data-testid": testid });

// Its errors say all that the detail does, and the form itself is the place they point to.
export function showRefusal(box, problem) {
  box.hidden = !problem;
  if (!problem) return box.replaceChildren();
  const said = problem.errors?.length ? { ...problem, detail: undefined } : problem;
  return box.replaceChildren(...problemNodes(said, { link: () => "" }));
}
