// The left panel's own calls, relative to the session's address.

import { call } from "./api.js";

export const getSchema = () => call("GET", "schema");
export const getFields = () => call("GET", "fields");
export const addPart = (kind) => call("POST", "parts", { kind });
export const copyPart = (index) => call("POST", `parts/${index}/copy`, {});
export const mirrorPart = (index, schedule) => call("POST", `parts/${index}/mirror`, { schedule });
export const movePart = (index, to) => call("POST", `parts/${index}/move`, { to });
export const removePart = (index) => call("DELETE", `parts/${index}`);
export const markPart = (index, marks) => call("POST", `parts/${index}/marks`, marks);
export const linkPairs = (linked) => call("POST", "pairs", { linked });
export const setMassProperties = (request) => call("POST", "mass-properties", request);
