// One row of the list: made once, then only written to, so that focus and selection stay where they are.

import { el, setText } from "./dom.js";
import { NONE } from "./format.js";
import { jobPage } from "./jobapi.js";
import { showActions } from "./jobactions.js";
import { KINDS, ProgressBar, casesText, chip, duration, isOver, nameOf, rateText, setChip, toldOf, tookText, when, whole } from "./jobwords.js";

const cell = (name, ...children) => el("td", { role: "cell", class: name }, ...children);

export class JobRow {
  constructor(job, { onAction }) {
    this.onAction = onAction;
    this.bar = new ProgressBar();
    this.chip = chip(job.state);
    this.link = el("a", { href: jobPage(job.id), "data-testid": "open-job" });
    this.about = el("small");
    this.reason = el("small", { class: "told", "data-testid": "reason" });
    this.cases = el("span", { "data-testid": "cases" });
    [this.rate, this.left] = [cell("number rate"), cell("number left")];
    this.made = el("time");
    this.actions = cell("actions");
    this.node = el("tr", { role: "row", "data-id": job.id, "data-testid": `job-${job.id}` },
      cell("", this.chip), cell("title", this.link, this.about, this.reason), cell("progress", this.bar.node, this.cases),
      this.rate, this.left, cell("number made", this.made), this.actions);
    this.show(job);
  }

  show(job) {
    this.job = job;
    const { progress, design } = job;
    this.node.dataset.state = job.state;
    this.node.dataset.done = progress.done;
    setChip(this.chip, job.state);
    setText(this.link, nameOf(job));
    setText(this.about, [KINDS[job.kind], job.name ? design.name : null].filter(Boolean).join(" · "));
    const { tone, text } = job.reason ? toldOf(job) : { tone: "calm", text: "" };
    this.reason.dataset.tone = tone;
    setText(this.reason, text);
    this.bar.show(job);
    const failed = progress.failed > 0 ? [" · ", el("b", {}, `${whole(progress.failed)} failed`)] : [];
    this.cases.replaceChildren(casesText(progress), ...failed);
    setText(this.rate, rateText(progress.rate));
    const [over, took] = [isOver(job), tookText(job)];
    setText(this.left, over && took !== NONE ? `took ${took}` : duration(over ? null : progress.seconds_left));
    this.left.toggleAttribute("data-over", over);
    this.left.toggleAttribute("data-none", this.left.textContent === NONE);
    this.made.dateTime = job.created;
    this.made.title = new Date(job.created).toLocaleString();
    setText(this.made, when(job.created));
    showActions(this.actions, job, (verb) => this.onAction(this.job, verb));
  }

  focus() {
    this.link.focus();
    this.node.scrollIntoView({ block: "nearest" });
  }
}
