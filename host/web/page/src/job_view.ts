// The jobs on a recording: a button each, the progress, and the result.
import type {Asker} from "./ask";
import type {Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import {JobFields} from "./job_form";
import {kJobs, kStates, optionWords, paceWords, whenWords, type JobLine} from "./jobs";
import {save} from "./plot_save";
import {untilZero, utf8} from "./text";
import {DocumentKind, JobState, Operation, type Job, type Recording} from "./wire";

const isUnderWay = ({state}: Job) => state === JobState.Running || state === JobState.Held;
const mayBeginAgain = ({state}: Job) => state === JobState.Cancelled || state === JobState.Interrupted || state === JobState.Failed;
const lineOf = (job: Job) => kJobs.find(({kind}) => kind === job.kind);

/** One job on one recording. */
class JobRow {
  private readonly word = el("strong");
  private readonly state = el("span", {class: "word"});
  private readonly bar = el("progress", {max: "1"});
  private readonly pace = el("span", {class: "pace"});
  private readonly when = el("span", {class: "pace"});
  private readonly cancel = el("button", {type: "button"}, ["Cancel"]);
  private readonly again = el("button", {type: "button"});
  private readonly keep = el("button", {type: "button"}, ["Save to print"]);
  private readonly words = el("p");
  private readonly text = el("pre", {tabindex: "0", role: "region"});
  readonly element: HTMLElement;
  private job: Job | undefined;

  constructor(private readonly car: Car, asker: Asker, again: (job: Job) => void) {
    this.cancel.onclick = () => this.job && asker.ask(Operation.Cancel, {value: [this.job.job]});
    this.again.onclick = () => this.job && again(this.job);
    this.keep.onclick = () => this.save();
    // The progress changes all the time: it is not read aloud.
    this.element = el("div", {class: "job"}, [
      el("div", {class: "job-head"}, [el("span", {role: "status"}, [this.word, " ", this.state]), this.bar, this.pace, this.when, this.cancel, this.again, this.keep]),
      this.words, this.text]);
  }

  draw(job: Job, line: JobLine, mayBegin: boolean): void {
    this.job = job;
    const [tone, word] = kStates[job.state as JobState];
    const options = optionWords(untilZero(job.options));
    setAttributes(this.element, {"data-tone": tone, "data-job": line.button});
    setText(this.word, line.does);
    setText(this.state, `${options === "" ? "" : `${options}: `}${word}`);
    this.bar.hidden = this.pace.hidden = this.cancel.hidden = !isUnderWay(job);
    setAttributes(this.bar, {value: job.progress.toFixed(2), "aria-label": line.does});
    setText(this.bar, `${Math.round(100 * job.progress)} %`);
    setText(this.pace, `${Math.round(100 * job.progress)} %: ${paceWords(job)}`);
    setText(this.when, whenWords(job, isUnderWay(job)));
    this.again.hidden = !line.again || !mayBeginAgain(job);
    this.again.disabled = !mayBegin;
    setText(this.again, line.again ?? "");
    const document = job.parts > 0 ? this.car.documents.text(job.job) : undefined;
    const isPage = job.document_kind === DocumentKind.Page;
    this.keep.hidden = !isPage || document === undefined;
    this.text.hidden = isPage || document === undefined;
    setAttributes(this.text, {"aria-label": line.does});
    if (!isPage && document !== undefined) setText(this.text, document.trimEnd());
    const said = utf8(job.text, job.size);
    setText(this.words, document === undefined && job.parts > 0 ? "its words are on their way"
      : line.form || isPage || document === undefined ? said : "");
  }

  private save(): void {
    const document = this.job && this.car.documents.text(this.job.job);
    const line = this.job && lineOf(this.job);
    if (document === undefined || !this.job || !line) return;
    save(new Blob([document], {type: "text/html"}), `${line.button.toLowerCase()} ${untilZero(this.job.recording)}.html`);
  }
}

/** What a job needs to know, behind its button. */
class Panel {
  readonly element: HTMLElement;
  readonly fields: JobFields;
  private readonly begin = el("button", {type: "submit"});

  constructor(readonly line: JobLine, readonly button: HTMLButtonElement, begin: () => void) {
    this.fields = new JobFields(line.form ?? "transfer");
    setText(this.begin, `Begin: ${line.button.toLowerCase()}`);
    this.element = el("form", {class: "panel", hidden: "", "aria-label": line.does}, [this.fields.element, this.begin]);
    this.element.onsubmit = (event) => {
      event.preventDefault();
      begin();
      this.show(false);
      button.focus();
    };
    this.show(false);
  }

  show(isOpen: boolean): void {
    this.element.hidden = !isOpen;
    setAttributes(this.button, {"aria-expanded": String(isOpen)});
  }

  draw(recording: Recording, transferTo: string, others: readonly string[], mayBegin: boolean): void {
    const can = this.fields.draw(recording, transferTo, others);
    this.begin.disabled = !can || !mayBegin;
  }
}

/** All that can be done with one recording. */
export class JobView {
  readonly element: HTMLElement;
  private readonly buttons: HTMLButtonElement[];
  private readonly panels: Panel[] = [];
  private readonly rows: JobRow[] = [];
  private readonly rowList = el("div");
  private readonly says = el("p", {role: "status"});
  private readonly controls = el("div", {class: "controls"});
  private recording = "";
  private asked = 0;

  constructor(private readonly car: Car, private readonly asker: Asker) {
    this.buttons = kJobs.map((line) => {
      const button = el("button", {type: "button", "data-ask": line.button}, [line.button]);
      if (line.form) {
        const panel = new Panel(line, button, () => this.ask(line, panel.fields.options()));
        this.panels.push(panel);
        button.onclick = () => this.open(panel);
      } else {
        button.onclick = () => this.ask(line, "");
      }
      return button;
    });
    this.controls.append(...this.buttons);
    this.element = el("div", {class: "jobs"}, [this.controls, ...this.panels.map(({element}) => element), this.says, this.rowList]);
  }

  /** @param others  recordings that this one can be compared with */
  draw(recording: Recording, isFinished: boolean, others: readonly string[], isFree: boolean, nowMs: number): void {
    this.recording = untilZero(recording.name);
    this.controls.hidden = !isFinished;
    const messages = [...this.car.jobs.values()].map(({message}) => message);
    const jobs = messages.filter(({jobs: count}) => count > 0);
    const transferTo = untilZero(messages[0]?.transfer_to ?? []);
    const worked = jobs.find(isUnderWay);
    const mayBegin = isFree && !worked && !this.asker.isUnderWay(Operation.Job, nowMs) && this.asker.mayAsk();
    this.buttons.forEach((button, k) => button.disabled = kJobs[k]?.form ? !this.asker.mayAsk() : !mayBegin);
    for (const panel of this.panels) {
      if (!isFinished) panel.show(false);
      panel.draw(recording, transferTo, others, mayBegin);
    }
    this.drawRows(jobs.filter((job) => untilZero(job.recording) === this.recording), mayBegin);
    const mine = this.asker.isNewest(Operation.Job, this.asked);
    const {text, isBad} = mine ? this.asker.says(Operation.Job, nowMs) : {text: "", isBad: false};
    const busy = worked && this.panels.some(({element}) => !element.hidden)
      ? `One job at a time: “${untilZero(worked.recording)}” is being worked on. Wait, or cancel that.` : "";
    // An accepted request shows below.
    setText(this.says, isBad ? text : this.asker.isUnderWay(Operation.Job, nowMs) ? text : busy);
    setAttributes(this.says, {"data-bad": String(isBad)});
  }

  /** The newest of each kind and options, in the order they were asked for: what is under a finger stays there. */
  private drawRows(jobs: readonly Job[], mayBegin: boolean): void {
    const newest = new Map<string, Job>();
    for (const job of [...jobs].sort((a, b) => a.job - b.job)) {
      const key = `${job.kind} ${untilZero(job.options)}`;
      newest.delete(key);
      newest.set(key, job);
    }
    const shown = [...newest.values()].flatMap((job) => {
      const line = lineOf(job);
      return line ? [{job, line}] : [];
    });
    while (this.rows.length > shown.length) this.rows.pop()?.element.remove();
    shown.forEach(({job, line}, k) => {
      let row = this.rows[k];
      if (!row) {
        this.rows.push(row = new JobRow(this.car, this.asker, (again) => this.askAgain(again)));
        this.rowList.append(row.element);
      }
      row.draw(job, line, mayBegin);
    });
  }

  private open(panel: Panel): void {
    const isOpen = panel.element.hidden === true;
    for (const each of this.panels) each.show(each === panel && isOpen);
  }

  private ask({kind}: JobLine, options: string): void {
    this.asked = this.asker.ask(Operation.Job, {value: [kind], text: this.recording + options});
  }

  private askAgain(job: Job): void {
    const options = untilZero(job.options);
    this.asked = this.asker.ask(Operation.Job, {value: [job.kind], text: this.recording + (options === "" ? "" : `/${options}`)});
  }
}
