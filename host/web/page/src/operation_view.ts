// Start, mark, stop: the actions of a person in the car.
import {Asker} from "./ask";
import {isBusy, type Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import {onHold} from "./hold";
import type {Key} from "./keys";
import type {Connection} from "./state";
import {Operation, RecorderState, type Recorder} from "./wire";

const kShown = [Operation.Start, Operation.Stop, Operation.Mark];
/** After so long what was done is no news. */
const kNewsMs = 10_000;

export class OperationView {
  readonly element: HTMLElement;
  readonly keys: readonly Key[] = [
    {key: "R", does: "record", run: () => this.start()},
    {key: " ", does: "set a mark", run: () => this.mark()},
    // Listed for the help; hold.ts handles it.
    {key: "hold Esc", does: "stop the recording (0.8 s)", run: () => undefined},
  ];
  private readonly name = el("input", {type: "text", id: "recording-name", maxlength: "60", autocomplete: "off",
                                       placeholder: "name: date and time", "aria-label": "Name of the next recording"});
  private readonly remark = el("input", {type: "text", id: "mark-text", maxlength: "120", autocomplete: "off",
                                         placeholder: "note for the mark", "aria-label": "Text of the next mark"});
  private readonly startButton = el("button", {type: "button", id: "start", class: "start"}, ["Record (R)"]);
  private readonly markButton = el("button", {type: "button", id: "mark"}, ["Mark (Space)"]);
  private readonly stopButton = el("button", {type: "button", id: "stop", class: "stop"},
                                   [el("span", {}, ["Stop: hold (Esc)"])]);
  private readonly idle = el("form", {class: "controls"}, [this.startButton, this.name]);
  private readonly busy = el("form", {class: "controls"}, [this.markButton, this.remark, this.stopButton]);
  private readonly words = el("p", {id: "operation-says", role: "status"});
  private connection: Connection = "never";
  private said: {text: string; sinceMs: number} = {text: "", sinceMs: 0};

  constructor(private readonly car: Car, private readonly asker: Asker) {
    this.element = el("section", {class: "operation", "aria-label": "Operation"}, [this.idle, this.busy, this.words]);
    this.startButton.onclick = () => this.start();
    this.markButton.onclick = () => this.mark();
    // Enter in a field presses the button beside it.
    this.idle.onsubmit = (event) => { event.preventDefault(); this.start(); };
    this.busy.onsubmit = (event) => { event.preventDefault(); this.mark(); };
    onHold(this.stopButton, ["Escape"], () => this.asker.ask(Operation.Stop));
  }

  draw(connection: Connection, nowMs: number): void {
    this.connection = connection;
    const recorder = this.recorder(nowMs);
    const why = this.obstacle(recorder);
    const records = recorder !== undefined && isBusy(recorder);
    const isStopping = recorder?.state === RecorderState.Stopping || this.asker.isUnderWay(Operation.Stop, nowMs);
    this.idle.hidden = records || recorder === undefined || recorder.operable === 0;
    this.busy.hidden = !records || recorder.operable === 0;
    this.startButton.disabled = why !== "" || this.asker.isUnderWay(Operation.Start, nowMs);
    this.markButton.disabled = why !== "" || isStopping;
    this.stopButton.disabled = why !== "" || isStopping;
    this.showWords(why, nowMs);
  }

  private showWords(why: string, nowMs: number): void {
    const newest = this.asker.newest(kShown);
    const {text, isBad} = why !== "" || newest === undefined ? {text: why, isBad: false} : this.asker.says(newest, nowMs);
    if (text !== this.said.text) this.said = {text, sinceMs: nowMs};
    const isOld = why === "" && nowMs - this.said.sinceMs > kNewsMs && newest !== undefined &&
      !this.asker.isUnderWay(newest, nowMs);
    setText(this.words, isOld ? "" : text);
    setAttributes(this.words, {"data-bad": String(isBad)});
  }

  /** The one that records, or else one that takes requests. */
  private recorder(nowMs: number): Recorder | undefined {
    const living = this.car.livingRecorders(nowMs);
    return living.find(isBusy) ?? living.find(({operable}) => operable !== 0) ?? living[0];
  }

  /** Why nothing can be asked; empty: it can. */
  private obstacle(recorder: Recorder | undefined): string {
    if (this.connection !== "open") return "";  // the state shows it in large letters
    if (!this.asker.mayAsk())
      return "To watch only: this page was opened without #token=… of the address that rb-web prints.";
    if (!recorder) return "No recorder to start: run rb-recorder --recordings FOLDER.";
    if (recorder.operable === 0)
      return "To watch only: this recorder was started with --record and ends where it was started.";
    return "";
  }

  private start(): void {
    if (this.idle.hidden || this.startButton.disabled) return;
    this.asker.ask(Operation.Start, {text: this.name.value.trim()});
    this.name.value = "";
    this.name.blur();
  }

  private mark(): void {
    if (this.busy.hidden || this.markButton.disabled) return;
    this.asker.ask(Operation.Mark, {text: this.remark.value.trim()});
    this.remark.value = "";
    this.remark.blur();
  }
}
