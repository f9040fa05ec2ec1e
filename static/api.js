// Every call of the studio's HTTP in one place. Addresses are relative, so any base path works.

export class ApiError extends Error {
  constructor(problem) {
    super(problem.title);
    this.problem = problem;
  }
}

async function readProblem(response) {
  let body = null;
  try {
    body = await response.json();
  } catch {
    // A proxy's error page is not JSON: the status line is all there is to say.
  }
  const title = response.status === 413 ? "The file is too large" : `The studio answered ${response.status}`;
  return { title, status: response.status, ...body };
}

export async function call(method, url, body) {
  const init = { method, headers: { accept: "application/json" } };
  if (body !== undefined) {
    init.headers["content-type"] = "application/json";
    init.body = typeof body === "string" ? body : JSON.stringify(body);
  }
  let response;
  try {
    response = await fetch(url, init);
  } catch {
    throw new ApiError({ title: "The studio cannot be reached", detail: "Check that it is still running, then try again.", status: 0, unreachable: true });
  }
  if (!response.ok) throw new ApiError(await readProblem(response));
  return response.status === 204 ? null : response.json();
}

export const getPresets = () => call("GET", "api/v1/presets");
export const createSession = (text) => call("POST", "sessions", text);
export const getState = () => call("GET", "state");
export const getPolar = () => call("GET", "polar");
export const saveDesign = (request) => call("POST", "save", request);
export const listDesigns = (query) => call("GET", `api/v1/designs?${new URLSearchParams(query)}`);
// Edits of one gesture (a drag) are one step of undo, however long it lasts.
export const edit = (patch, gesture) => call("POST", "edit", { patch, gesture });
export const editPaired = (patch) => call("POST", "edit", { patch, paired: true }); // mirror images go along
export const undo = () => call("POST", "undo");
export const redo = () => call("POST", "redo");
export const openDesign = (text) => call("PUT", "design", text);
export const trimBallast = () => call("POST", "trim-ballast");
export const setCamera = (view, covered) => call("POST", "camera", { view, covered });
export const postClock = (t) => call("POST", "clock", { t });
export const postShown = (wxyz) => call("POST", "shown", { wxyz });
export const showInScene = (choices) => call("POST", "display", choices);
export const selectComponent = (component) => call("POST", "select", { component });

// A JSON file is checked here first: a message about this file is better than one about a request.
export async function readDesignFile(file) {
  const text = await file.text();
  try {
    JSON.parse(text);
  } catch (error) {
    throw new ApiError({ title: `${file.name} is not a JSON file`, detail: error.message, status: 0,
      errors: [{ message: "A design file is JSON text, saved by this studio.", hint: "Choose a file that Export wrote." }] });
  }
  return text;
}

// Runs at most one call at a time; of the calls asked for meanwhile only the last is made.
export function latestWins(send) {
  let running = null;
  let next = null;
  async function drain() {
    while (next) {
      const job = next;
      next = null;
      try {
        job.resolve(await send(...job.args));
      } catch (error) {
        job.reject(error);
      }
    }
    running = null;
  }
  return (...args) => new Promise((resolve, reject) => {
    next?.resolve(undefined);
    next = { args, resolve, reject };
    running ??= drain();
  });
}
