// Where this program is: the folder in which static/ lies, under any base path. Modules are served from static/ itself
// and from static/<release>/ alike.

export const ROOT = new URL(import.meta.url.replace(/static\/([0-9a-f]{16}\/)?[^/]*$/, ""));
