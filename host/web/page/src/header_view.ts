// The state, always in the same place, by word, shape and colour.
import {SayingLines} from "./alarm";
import type {Car} from "./car";
import {el, setAttributes, setText, svg} from "./dom";
import {stateWord, warnings, type Alarm, type Connection} from "./state";
import {utf8} from "./text";
import {RecorderState, type Recorder} from "./wire";
import {duration} from "./words";

/** Told apart without colours. */
const kShapes: Readonly<Record<Alarm, string>> = {
  good: "M16 3a13 13 0 1 0 0 26a13 13 0 1 0 0-26z",     // disc
  idle: "M5 5h22v22h-22z",                              // square
  warn: "M16 3l14 26h-28z",                             // triangle
  bad: "M7 3l9 9l9-9l4 4l-9 9l9 9l-4 4l-9-9l-9 9l-4-4l9-9l-9-9z",  // cross
};

export class HeaderView {
  readonly element: HTMLElement;
  private readonly shape = svg("path");
  private readonly word = el("span", {class: "word"});
  private readonly time = el("span", {class: "time"});
  private readonly amounts = el("p", {class: "amounts"});
  private readonly first = el("p", {class: "first"});
  private readonly sayings = new SayingLines();
  private readonly detail = el("div", {class: "detail", role: "alert"}, [this.first, this.sayings.element]);
  private readonly state: HTMLElement;

  /** @param operation  the row that stays in sight with the state */
  constructor(buttons: readonly HTMLElement[], operation: HTMLElement) {
    this.state = el("h1", {class: "state", id: "state"}, [
      svg("svg", {viewBox: "0 0 32 32", "aria-hidden": "true"}, [this.shape]), this.word, this.time]);
    this.element = el("header", {}, [this.state, this.amounts, el("div", {class: "buttons"}, buttons), this.detail, operation]);
  }

  draw(car: Car, connection: Connection, nowMs: number): void {
    const {alarm, word, detail, recordingS, recorder} = stateWord(car, connection, nowMs);
    setAttributes(this.state, {"data-alarm": alarm});
    setAttributes(this.shape, {d: kShapes[alarm]});
    setText(this.word, word);
    setText(this.time, recordingS === undefined ? "" : duration(recordingS));
    setText(this.amounts, recorder ? amounts(recorder) : "");
    setText(this.first, detail);
    this.first.hidden = detail === "";
    this.sayings.draw(warnings(car, nowMs));
  }

  /** What a page in the background, which is not drawn, still says. */
  name(car: Car, connection: Connection, nowMs: number): void {
    document.title = `${stateWord(car, connection, nowMs).word} – roadbalance`;
  }
}

/** Name, what is written, and how long the disk will do. */
function amounts(recorder: Recorder): string {
  const seconds = recorder.seconds_left;
  const free = `${(recorder.bytes_free / 1e9).toFixed(1)} GB free`;
  const hours = seconds < 0 ? "" : `${(seconds / 3600).toFixed(seconds < 36_000 ? 1 : 0)} h`;
  if (recorder.state === RecorderState.Idle || recorder.state === RecorderState.Armed)
    return hours === "" ? free : `${free}, room for ${hours}`;
  // A recorder sends its first status before it has examined its disk.
  const left = seconds < 0 ? (recorder.bytes_free > 0 ? free : "") : `${hours} left`;
  const name = utf8(recorder.name, recorder.name_size);
  return [...(name === "" ? [] : [name]), `${(recorder.bytes_recorded / 1e9).toFixed(2)} GB`, ...(left === "" ? [] : [left])].join(" · ");
}
