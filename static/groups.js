// Groups of readouts that open and close, and stay as they were left.

const KEY = "glider-studio.groups";

function remembered() {
  try {
    return JSON.parse(localStorage.getItem(KEY)) ?? {};
  } catch {
    return {};
  }
}

export function connectGroups(root) {
  const open = remembered();
  for (const group of root.querySelectorAll("details[data-group]")) {
    const { group: name } = group.dataset;
    if (name in open) group.open = open[name] === true;
    group.addEventListener("toggle", () => {
      try {
        localStorage.setItem(KEY, JSON.stringify({ ...remembered(), [name]: group.open }));
      } catch {
        // Where the browser keeps nothing, groups open as they come.
      }
    });
  }
}
