// Light or dark: the person's choice, else the browser's; remembered, and told to whatever draws by itself.

const KEY = "glider-studio.theme";
const WORDS = { auto: "as the browser", light: "light", dark: "dark" };
const lightPreferred = matchMedia("(prefers-color-scheme: light)");

export const scheme = () => document.documentElement.dataset.theme;

// Called after each change, when the variables of tokens.css have their new values.
export const onScheme = (listener) => document.addEventListener("scheme", () => listener(scheme()));

export function chosenTheme() {
  try {
    const kept = localStorage.getItem(KEY);
    return kept in WORDS ? kept : "auto";
  } catch {
    return "auto";
  }
}

export function chooseTheme(theme) {
  try {
    localStorage.setItem(KEY, theme);
  } catch {
    // Not remembered where the browser keeps nothing; chosen for now all the same.
  }
  apply(theme);
}

function apply(theme) {
  const wanted = theme === "auto" ? (lightPreferred.matches ? "light" : "dark") : theme;
  if (wanted === scheme()) return;
  document.documentElement.dataset.theme = wanted;
  document.dispatchEvent(new CustomEvent("scheme"));
}

lightPreferred.addEventListener("change", () => apply(chosenTheme()));
window.addEventListener("storage", ({ key }) => key === KEY && apply(chosenTheme())); // chosen in another tab

// A button that goes round: as the browser, light, dark.
export function connectTheme(button) {
  function show() {
    const theme = chosenTheme();
    const words = `Colours: ${WORDS[theme]}`;
    button.dataset.choice = theme;
    button.setAttribute("aria-label", words);
    button.title = words;
  }
  button.addEventListener("click", () => {
    const order = Object.keys(WORDS);
    chooseTheme(order[(order.indexOf(chosenTheme()) + 1) % order.length]);
    show();
  });
  show();
}
