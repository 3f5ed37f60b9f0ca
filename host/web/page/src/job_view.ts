// What can be done with a recording: a button each, how far it is, and what came of it.
import type {Asker} from "./ask";
import type {Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import {kJobs, kStates, type JobLine} from "./jobs";
import {save} from "./plot_save";
import {untilZero, utf8} from "./text";
import {DocumentKind, JobState, Operation, type Job} from "./wire";

const isUnderWay = ({state}: Job) => state === JobState.Running || state === JobState.Held;

/** The newest job of a kind on one recording. */
class JobRow {
  private readonly word = el("strong");
  private readonly state = el("span", {class: "word"});
  private readonly bar = el("progress", {max: "1"});
  private readonly cancel = el("button", {type: "button"}, ["Cancel"]);
  private readonly keep = el("button", {type: "button"}, ["Save to print"]);
  private readonly words = el("p");
  private readonly text = el("pre", {tabindex: "0", role: "region"});
  readonly element: HTMLElement;
  private job: Job | undefined;

  constructor(private readonly line: JobLine, private readonly car: Car, asker: Asker) {
    setText(this.word, line.does);
    setAttributes(this.bar, {"aria-label": line.does});
    setAttributes(this.text, {"aria-label": line.does});
    this.cancel.onclick = () => this.job && asker.ask(Operation.Cancel, {value: [this.job.job]});
    this.keep.onclick = () => this.save();
    this.element = el("div", {class: "job", hidden: ""}, [
      el("div", {class: "job-head", role: "status"}, [this.word, this.state, this.bar, this.cancel, this.keep]), this.words, this.text]);
  }

  draw(job: Job | undefined): void {
    this.job = job;
    this.element.hidden = !job;
    if (!job) return;
    const [tone, word] = kStates[job.state as JobState];
    const before = untilZero(job.before);
    setAttributes(this.element, {"data-tone": tone, "data-job": this.line.button});
    setText(this.state, `${before === "" ? "" : `compared with “${before}”: `}${word}`);
    this.bar.hidden = this.cancel.hidden = !isUnderWay(job);
    setAttributes(this.bar, {value: job.progress.toFixed(2)});
    setText(this.bar, `${Math.round(100 * job.progress)} %`);
    const document = job.parts > 0 ? this.car.documents.text(job.job) : undefined;
    const isPage = job.document_kind === DocumentKind.Page;
    this.keep.hidden = !isPage || document === undefined;
    this.text.hidden = isPage || document === undefined;
    if (!isPage && document !== undefined) setText(this.text, document.trimEnd());
    const said = utf8(job.text, job.size);
    setText(this.words, document === undefined && job.parts > 0 ? "its words are on their way" : isPage || document === undefined ? said : "");
  }

  private save(): void {
    const document = this.job && this.car.documents.text(this.job.job);
    if (document === undefined || !this.job) return;
    save(new Blob([document], {type: "text/html"}), `${this.line.button.toLowerCase()} ${untilZero(this.job.recording)}.html`);
  }
}

/** All that can be done with one recording. */
export class JobView {
  readonly element: HTMLElement;
  private readonly buttons: HTMLButtonElement[];
  private readonly rows: JobRow[];
  private readonly before = el("select");
  private readonly compare = el("label", {}, ["Report compared with ", this.before]);
  private readonly says = el("p", {role: "status"});
  private readonly controls = el("div", {class: "controls"});
  private recording = "";
  private offered = "";
  private asked = 0;

  constructor(private readonly car: Car, private readonly asker: Asker) {
    this.buttons = kJobs.map((line) => {
      const button = el("button", {type: "button", "data-ask": line.button}, [line.button]);
      button.onclick = () => this.ask(line);
      return button;
    });
    this.rows = kJobs.map((line) => new JobRow(line, car, asker));
    this.controls.append(...this.buttons, this.compare);
    this.element = el("div", {class: "jobs"}, [
      this.controls, this.says, ...this.rows.map(({element}) => element)]);
  }

  /** @param others  recordings that this one can be compared with */
  draw(recording: string, isFinished: boolean, others: readonly string[], mayBegin: boolean, nowMs: number): void {
    this.recording = recording;
    this.controls.hidden = !isFinished;
    this.offer(others);
    const jobs = [...this.car.jobs.values()].map(({message}) => message).filter(({jobs: count}) => count > 0);
    const busy = jobs.some(isUnderWay) || this.asker.isUnderWay(Operation.Job, nowMs);
    for (const button of this.buttons) button.disabled = !mayBegin || busy || !this.asker.mayAsk();
    this.rows.forEach((row, k) => row.draw(jobs.filter((job) => job.kind === kJobs[k]?.kind && untilZero(job.recording) === recording)
      .sort((a, b) => b.job - a.job)[0]));
    const mine = this.asker.isNewest(Operation.Job, this.asked);
    const {text, isBad} = mine ? this.asker.says(Operation.Job, nowMs) : {text: "", isBad: false};
    // What was obeyed is seen below.
    setText(this.says, isBad ? text : this.asker.isUnderWay(Operation.Job, nowMs) ? text : "");
    setAttributes(this.says, {"data-bad": String(isBad)});
  }

  private ask({kind, takesBefore}: JobLine): void {
    const before = takesBefore && this.before.value !== "" ? `/${this.before.value}` : "";
    this.asked = this.asker.ask(Operation.Job, {value: [kind], text: this.recording + before});
  }

  private offer(others: readonly string[]): void {
    this.compare.hidden = others.length === 0;
    const offered = [this.recording, ...others].join("/");
    if (offered === this.offered) return;
    this.offered = offered;
    const chosen = this.before.value;
    this.before.replaceChildren(el("option", {value: ""}, ["none"]), ...others.map((name) => el("option", {value: name}, [name])));
    this.before.value = others.includes(chosen) ? chosen : "";
  }
}
