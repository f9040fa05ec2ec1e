// Groups of readouts that open and close, and stay as they were left.

const KEY = "glider-studio.groups";

function remembered() {
  try {
    return JSON.parse(localStorage.getItem(KEY)) ?? {};
  } catch {
    return {};
  }
}

// Opens a group that has something to tell, unless it was folded by hand; that it opened is not remembered.
export function openGroup(group) {
  if (group.open || remembered()[group.dataset.group] === false) return;
  group.dataset.opened = "";
  group.open = true;
}

export function connectGroups(root) {
  const open = remembered();
  for (const group of root.querySelectorAll("details[data-group]")) {
    const { group: name } = group.dataset;
    if (name in open) group.open = open[name] === true;
    group.addEventListener("toggle", () => {
      if ("opened" in group.dataset) {
        delete group.dataset.opened;
        return;
      }
      try {
        localStorage.setItem(KEY, JSON.stringify({ ...remembered(), [name]: group.open }));
      } catch {
        // Where the browser keeps nothing, groups open as they come.
      }
    });
  }
}
