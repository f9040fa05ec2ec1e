// Keeps viser's number boxes honest: they drop what they do not know, so that a typed 1e3 would become 13 without a word.
// Instead the box says so and takes back the number it had.

const TYPED = /^[\d.,+\-−]*$/;
const PASTED = /^\s*[+\-−]?\d*\.?\d*\s*$/;
const SWALLOW = 900; // ms: the rest of what is being typed belongs to the refused number
const MESSAGE = "Plain numbers only, such as 0.001 or 1000; the last value is kept.";

const isNumberBox = (target) => target?.tagName === "INPUT" && ["decimal", "numeric"].includes(target.inputMode);

function restore(box, value) {
  const view = box.ownerDocument.defaultView;
  Object.getOwnPropertyDescriptor(view.HTMLInputElement.prototype, "value").set.call(box, value);
  box.dispatchEvent(new view.Event("input", { bubbles: true }));
  box.select();
}

function complain(box) {
  box.setCustomValidity(MESSAGE);
  box.reportValidity();
  box.ownerDocument.defaultView.setTimeout(() => box.setCustomValidity(""), 3000);
}

export function guardNumbers(doc) {
  let before = "";
  let until = 0;
  doc.addEventListener("focusin", ({ target }) => {
    if (isNumberBox(target)) before = target.value;
  });
  doc.addEventListener("keydown", ({ key, target }) => {
    if (key === "Enter" && isNumberBox(target)) before = target.value;
  }, true);
  doc.addEventListener("beforeinput", (event) => {
    const { target, data, inputType } = event;
    if (!isNumberBox(target) || !inputType.startsWith("insert") || data === null) return;
    const swallowed = performance.now() < until;
    if (!swallowed && (inputType === "insertText" ? TYPED : PASTED).test(data)) return;
    event.preventDefault();
    if (swallowed) return;
    until = performance.now() + SWALLOW;
    restore(target, before);
    complain(target);
  }, true);
}
