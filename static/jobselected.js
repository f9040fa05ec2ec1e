// The selected cases side by side: one row a value, one column a case; above them why one failed, and what can be done.

import { $, el } from "./dom.js";
import { designInStudio } from "./jobapi.js";
import { slotColor, slotDash } from "./jobplots.js";
import { mayMend, reasonParts, whole } from "./jobwords.js";

const ENDED = {
  refused: "was refused before it could run", crashed: "broke off", cancelled: "was broken off", diverged: "ran away",
  step_too_small: "stopped early: its step became too small", too_many_steps: "stopped early: it reached the limit of steps",
};
const MOST_TOLD = 6; // parameters in a note; the table below has all

export function showSelected({ table, selected, paths, job, links }) {
  const known = selected.filter(({ n }) => table.rows.has(n)).map(({ n, slot }) => ({ n, slot, row: table.rows.get(n) }));
  $("selected").hidden = known.length === 0;
  $("selected").dataset.cases = known.map(({ n }) => n).join(" ");
  showNotes(known, { table, paths, job, links });
  const line = (name, cells, { unit = "", title = null } = {}) => el("tr", {}, el("th", { scope: "row", title }, name, unit ? el("small", {}, ` ${unit}`) : null), ...cells, el("td", { class: "rest" }));
  const rows = table.infos.map((info) => {
    const cells = known.map(({ row }) => el("td", {}, table.text(info.name, row)));
    return line(table.words(info.name), cells, { unit: info.numeric ? table.scale(info.name).symbol : "", title: info.meaning });
  });
  const status = line("Ended", known.map(({ row }) => el("td", { class: table.group[row] === null ? null : "failed-count" }, table.status[row])));
  const head = known.map((one) => caseHead(one, { table, job, links }));
  $("selected-head").replaceChildren(el("th", { scope: "col" }, el("span", { class: "visually-hidden" }, "Value")), ...head, el("td", { class: "rest" }));
  $("selected-rows").replaceChildren(status, ...rows);
}

function lineKey(slot) {
  const key = el("i", { class: "line-key", "aria-hidden": "true" });
  key.style.borderTop = `2.5px ${slotDash(slot) === "dash" ? "dashed" : "solid"} ${slotColor(slot)}`;
  return key;
}

function caseHead({ n, slot, row }, { table, job, links }) {
  const drop = el("button", { class: "btn small", type: "button", "aria-label": `Drop case ${n}`, title: "Drop it", "data-testid": `drop-${n}`, onclick: () => links.drop(n) }, "×");
  const ways = table.group[row] === null ? el("div", { class: "case-links" }, ...openAndDownload(n, { job, links })) : null;
  return el("th", { scope: "col" }, el("div", { class: "case-head" }, table.ran(n) ? lineKey(slot) : null, `Case ${n}`, drop), ways);
}

const openLink = (n, { links, label = "Open in the studio" }) => el("a", { href: links.studio(n), "data-testid": `open-case-${n}`, "aria-label": `Open case ${n} in the studio` }, label);
const downloadLink = (n, { job, links }) => el("a", { href: links.design(n), download: `${job.id}-case-${n}.json`, "aria-label": `Download the design of case ${n}` }, "Download design");
const openAndDownload = (n, about) => [openLink(n, about), downloadLink(n, about)];

function showNotes(known, { table, paths, job, links }) {
  const notes = known.map(({ n, row }) => {
    if (table.group[row] !== null) return failure(n, row, { table, job, links });
    const problem = paths.problemOf(n);
    return problem && el("li", { class: "box", "data-testid": `note-${n}` }, el("p", {}, el("strong", {}, `Case ${n} has no path. `), problem));
  });
  $("selected-notes").replaceChildren(...notes.filter(Boolean));
}

// Why a case failed, with what values, and what can work: never a link that leads to the same refusal.
function failure(n, row, { table, job, links }) {
  const given = table.infos.filter(({ role }) => role === "parameter");
  const values = given.slice(0, MOST_TOLD).map(({ name }) => `${table.words(name)} ${table.textWithUnit(name, row)}`);
  const more = given.length > MOST_TOLD ? ` and ${given.length - MOST_TOLD} more` : "";
  const status = table.status[row];
  return el("li", { class: "box bad", "data-testid": `note-${n}` },
    el("p", {}, el("strong", {}, `Case ${n} ${ENDED[status] ?? `ended: ${status}`}.`)),
    ...reasonParts(table.reason[row]).map(({ pointer, text }) => el("p", {}, text, pointer && el("span", { class: "where" }, pointer))),
    values.length ? el("p", { class: "given" }, `With ${values.join(" · ")}${more}`) : null,
    el("div", { class: "ways" }, ...ways(n, row, { table, job, links })));
}

function ways(n, row, { table, job, links }) {
  const [status, group] = [table.status[row], table.group[row]];
  const alike = table.group.reduce((sum, other) => sum + (other === group), 0);
  const all = alike > 1 ? el("button", { class: "link-button", type: "button", onclick: () => links.group(group) }, `Show the ${whole(alike)} that failed so`) : null;
  if (status === "refused") return [el("span", {}, "Its values make no glider, so there is nothing to open."), instead(row, { table, job, links }), all];
  if (mayMend(status)) return [el("span", {}, "A retry of the job may mend it."), downloadLink(n, { job, links }), all];
  return [...openAndDownload(n, { job, links }), all];
}

// What opens in place of a case that cannot: the nearest one that went well, else the design that was varied.
function instead(row, { table, job, links }) {
  const near = table.nearestFine(row);
  if (near !== null) return openLink(near, { links, label: `Open case ${near}, the nearest that went well` });
  return job.design.id ? el("a", { href: designInStudio(job.design.id) }, "Open the design that was varied") : null;
}
