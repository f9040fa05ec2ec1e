// The page's state and who wants to know; the server's State is replaced whole, never edited here.

export function createStore(initial) {
  const values = { ...initial };
  const listeners = [];
  return {
    get: (key) => values[key],
    set(changes) {
      const changed = Object.keys(changes).filter((key) => values[key] !== changes[key]);
      Object.assign(values, changes);
      for (const { keys, listener } of listeners) {
        if (keys.some((key) => changed.includes(key))) listener(values);
      }
    },
    // Calls at once too, so that a view needs no second path for its first drawing.
    watch(keys, listener) {
      listeners.push({ keys, listener });
      listener(values);
    },
  };
}
