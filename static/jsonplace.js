// Where in a JSON text the value of a JSON Pointer stands. The text is known to be JSON: JSON.parse has read it.

const TOKEN = /\s*("(?:[^"\\]|\\.)*"|[-+\w.]+|[[\]{},:])/gy;

function* tokensOf(text) {
  TOKEN.lastIndex = 0;
  for (let found = TOKEN.exec(text); found; found = TOKEN.exec(text)) yield { word: found[1], begin: TOKEN.lastIndex - found[1].length, end: TOKEN.lastIndex };
}

function skip(tokens, first) {
  let depth = 0;
  for (let i = first; i < tokens.length; i += 1) {
    if ("[{".includes(tokens[i].word)) depth += 1;
    else if ("]}".includes(tokens[i].word)) depth -= 1;
    if (depth === 0) return i;
  }
  return tokens.length - 1;
}

// The first token of a member of the object or list that begins at `at`, -1 where there is none.
function member(tokens, at, step) {
  const named = tokens[at].word === "{";
  if (!named && tokens[at].word !== "[") return -1;
  let k = 0;
  for (let i = at + 1; i < tokens.length && !"]}".includes(tokens[i].word); k += 1) {
    const key = named ? JSON.parse(tokens[i].word) : String(k);
    const value = named ? i + 2 : i;
    if (key === step) return value;
    i = skip(tokens, value) + 1;
    if (tokens[i]?.word === ",") i += 1;
  }
  return -1;
}

// Begin and end of the value, or of the nearest that exists on the way to it; null for the whole.
export function placeOf(text, pointer) {
  let tokens;
  try {
    JSON.parse(text);
    tokens = [...tokensOf(text)];
  } catch {
    return null;
  }
  let at = 0;
  for (const step of pointer.split("/").slice(1).map((s) => s.replaceAll("~1", "/").replaceAll("~0", "~"))) {
    const found = member(tokens, at, step);
    if (found < 0) break;
    at = found;
  }
  return at === 0 ? null : [tokens[at].begin, tokens[skip(tokens, at)].end];
}
