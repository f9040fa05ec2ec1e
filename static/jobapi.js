// Every call about jobs in one place. Addresses follow from where the program is, so any base path works.

import { call } from "./api.js";
import { ROOT } from "./root.js";

const API = new URL("api/v1/", ROOT);

const address = (path) => new URL(path, API).href;
const job = (id) => `jobs/${encodeURIComponent(id)}`;

function query(values) {
  const given = Object.entries(values).filter(([, value]) => value != null && value !== "");
  return given.length ? `?${new URLSearchParams(given)}` : "";
}

export const API_ADDRESS = API.href;
export const jobPage = (id) => new URL(job(id), ROOT).href;
// The one place that knows how a case, and a stored design, open in the studio.
export const caseInStudio = (id, n) => new URL(`d${query({ run: `${id}.${n}` })}`, ROOT).href;
export const designInStudio = (id) => new URL(`d/${encodeURIComponent(id)}`, ROOT).href;

export const listJobs = (filters) => call("GET", address(`jobs${query(filters)}`));
export const getJob = (id) => call("GET", address(job(id)));
export const createJob = (text, { fresh }) => call("POST", address(`jobs${query({ fresh: fresh || null })}`), text);
export const deleteJob = (id) => call("DELETE", address(job(id)));
export const changeJob = (id, verb) => call("POST", address(`${job(id)}:${verb}`));
export const eventsAddress = (id) => address(`${job(id)}/events`);
export const getHealth = () => call("GET", new URL("healthz", ROOT).href);
export const getSummary = (id) => call("GET", address(`${job(id)}/summary`));
export const getResults = (id) => call("GET", address(`${job(id)}/results`));
export const getCases = (id, cursor) => call("GET", address(`${job(id)}/cases${query({ limit: 1000, cursor })}`));
export const getPath = (id, n) => call("GET", address(`${job(id)}/cases/${n}/trajectory${query({ columns: "x,y,z", max_points: 400 })}`));
export const getExampleDesign = () => call("GET", address("presets/canete-dual-bellows"));

// Files are plain links: the browser shows how far they are, however large.
export const FORMATS = { csv: "CSV", parquet: "Parquet", netcdf: "NetCDF", mat: "MATLAB", json: "JSON" };
export const resultsFile = (id, format) => address(`${job(id)}/results${query({ format })}`);
export const documentFile = (id) => address(`${job(id)}/spec`);
export const caseDesign = (id, n) => address(`${job(id)}/cases/${n}/design`);
