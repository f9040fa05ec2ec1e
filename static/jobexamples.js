// Examples that make a job: for the empty list as code to copy, for the dialog as a whole document.

import { $ } from "./dom.js";
import { API_ADDRESS, getExampleDesign } from "./jobapi.js";

const METHOD = {
  kind: "full_factorial",
  parameters: [{ pointer: "/vehicle/components/1/position/0", low: 0.15, high: 0.2, count: 51 }],
};
const NAME = "Where to put the front bellows";

const HEAD = { format: "glider-batch", version: 1, kind: "sweep", name: NAME };

// The design last: who reads the document first sees what it asks for.
export async function exampleDocument() {
  return JSON.stringify({ ...HEAD, method: METHOD, design: await getExampleDesign() }, null, 1);
}

const WAYS = {
  python: {
    note: "httpx is installed with the studio. A server with a token wants headers={\"Authorization\": \"Bearer …\"} too.",
    code: () => `import httpx

studio = httpx.Client(base_url="${API_ADDRESS}")
design = studio.get("presets/canete-dual-bellows").json()
front = {"pointer": "/vehicle/components/1/position/0", "low": 0.15, "high": 0.20, "count": 51}
batch = {
    "format": "glider-batch", "version": 1, "kind": "sweep", "name": "${NAME}",
    "design": design, "method": {"kind": "full_factorial", "parameters": [front]},
}
job = studio.post("jobs", json=batch).raise_for_status().json()
print(job["id"], job["state"])`,
  },
  curl: {
    note: "batch.json is a batch document; “Start from an example” under New job… gives a whole one.",
    code: () => `curl ${API_ADDRESS}jobs \\
  -H "Content-Type: application/json" \\
  --data-binary @batch.json`,
  },
  cli: {
    note: "This computes the same job where you type it, without the studio: it does not come into this list.",
    code: () => `glider-studio presets canete-dual-bellows > design.json
cat > batch.json <<'END'
${JSON.stringify({ ...HEAD, design: "design.json", method: METHOD }, null, 1)}
END
glider-studio batch batch.json`,
  },
};

export function showExamples() {
  const show = () => {
    const { code, note } = WAYS[document.querySelector("[name=way]:checked").value];
    $("snippet").textContent = code();
    $("way-note").textContent = note;
    $("copy").textContent = "Copy";
  };
  for (const radio of document.querySelectorAll("[name=way]")) radio.addEventListener("change", show);
  $("copy").addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText($("snippet").textContent);
      $("copy").textContent = "Copied";
    } catch {
      // Without leave to use the clipboard the text is at least marked, ready to copy.
      getSelection().selectAllChildren($("snippet"));
      $("copy").textContent = "Marked";
    }
  });
  show();
}
