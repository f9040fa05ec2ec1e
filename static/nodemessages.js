// The viewer client's own messages that place, turn, size and show a node of its scene.

export const messages = {
  position: (name, position) => ({ type: "SetPositionMessage", name, position, owner: "" }),
  wxyz: (name, wxyz) => ({ type: "SetOrientationMessage", name, wxyz, owner: "" }),
  scale: (name, scale) => ({ type: "SceneNodeUpdateMessage", name, updates: { scale }, owner: "" }),
  visible: (name, visible) => ({ type: "SetSceneNodeVisibilityMessage", name, visible, owner: "" }),
};
