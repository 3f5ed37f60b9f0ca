// The angle of a wheel's zero mark: read while the wheel is turned by hand and recorded, set between recordings.
import type {Asker} from "./ask";
import {el, setAttributes, setText} from "./dom";
import {angleOf, kWheelNames} from "./wheel_place";
import {AnswerState, Operation} from "./wire";

const kDegree = Math.PI / 180;
const kBegin = 0, kRead = 1;

function label(id: string, name: string, input: HTMLElement): HTMLLabelElement {
  input.id = id;
  return el("label", {for: id}, [name, input]);
}

const angleField = (min: string) => el("input", {type: "number", min, max: "360", step: "any", required: "", autocomplete: "off"});

export class MarkView {
  private readonly wheel = el("select");
  private readonly where = el("input", {autocomplete: "off", type: "text", placeholder: "10:30 or 45°", required: ""});
  private readonly datum = angleField("-360");
  private readonly sigma = angleField("0.01");
  private readonly begin = el("button", {type: "button", id: "begin-reading"}, ["Begin with this wheel"]);
  private readonly read = el("button", {type: "submit", id: "set-reading"}, ["Read"]);
  private readonly set = el("button", {type: "submit", id: "set-datum"}, ["Set zero mark"]);
  private readonly saysReading = el("p", {role: "status", id: "says-reading"});
  private readonly saysDatum = el("p", {role: "status", id: "says-datum"});
  private readonly reading: HTMLFormElement;
  private readonly setting: HTMLFormElement;
  /** The readings that the fields were filled from. */
  private filled = 0;
  /** Datum and its uncertainty of each wheel, as they stood in the fields; and whose stand there now. */
  private readonly found = new Map<number, readonly [string, string]>();
  private shown = 0;
  readonly element: HTMLElement;

  constructor(private readonly asker: Asker) {
    this.wheel.append(...kWheelNames.map((name, k) => el("option", {value: String(k)}, [name])));
    this.reading = el("form", {class: "controls"}, [
      label("mark-wheel", "wheel", this.wheel), this.begin, label("mark-where", "its reference point is at", this.where), this.read]);
    this.setting = el("form", {class: "controls"}, [
      label("mark-datum", "its mark fires at, °", this.datum), label("mark-sigma", "known to ±, °", this.sigma), this.set]);
    this.element = el("section", {class: "setting", id: "zero-mark"}, [
      el("h2", {}, ["Zero mark of a wheel"]),
      el("p", {}, ["Jack the wheel up and start a recording: nodes send the edges of wheels only then. Begin; turn the wheel forward by " +
                   "hand until its zero mark fires, let it stand, and say where its reference point (the valve) is: the clock as seen " +
                   "from outside the car, or degrees from the top in the direction of forward rotation. Do that five times. Then stop the " +
                   "recording and set what was found. rb datum finds it by a trial weight."]),
      this.reading, this.saysReading, this.setting, this.saysDatum]);
    this.begin.onclick = () => this.ask(kBegin, 0);
    this.reading.onsubmit = (event) => {
      event.preventDefault();
      const angle_rad = angleOf(this.place(), this.where.value);
      this.where.setCustomValidity(angle_rad === undefined ? "the clock (10:30) or degrees (45°); not 10, which may be either" : "");
      if (angle_rad === undefined) this.where.reportValidity();
      else if (!this.read.disabled) this.ask(kRead, angle_rad);
    };
    this.where.oninput = () => this.where.setCustomValidity("");
    this.wheel.onchange = () => this.change();
    this.setting.onsubmit = (event) => {
      event.preventDefault();
      if (this.set.disabled) return;
      this.asker.ask(Operation.Datum, {
        channel: this.place(), value: [this.datum.valueAsNumber * kDegree, this.sigma.valueAsNumber * kDegree]});
    };
  }

  /**
   * @param whyNotRead  nothing can be read now; empty: it can
   * @param whyNotSet   nothing can be set now; empty: it can
   */
  draw(whyNotRead: string, whyNotSet: string, nowMs: number): void {
    const isAsked = [Operation.Reading, Operation.Datum].some((operation) => this.asker.isUnderWay(operation, nowMs));
    for (const button of [this.begin, this.read]) button.disabled = whyNotRead !== "" || isAsked;
    this.set.disabled = whyNotSet !== "" || isAsked;
    this.fill();
    for (const [says, operation, why] of [[this.saysReading, Operation.Reading, whyNotRead], [this.saysDatum, Operation.Datum, whyNotSet]] as const) {
      const {text, isBad} = this.asker.says(operation, nowMs);
      setText(says, text || why);
      setAttributes(says, {"data-bad": String(isBad)});
    }
  }

  private place(): number {
    return Number(this.wheel.value);
  }

  /** What stands in the fields is of the wheel before: it comes back with that wheel. */
  private change(): void {
    this.found.set(this.shown, [this.datum.value, this.sigma.value]);
    this.shown = this.place();
    [this.datum.value, this.sigma.value] = this.found.get(this.shown) ?? ["", ""];
  }

  private forget(): void {
    this.datum.value = this.sigma.value = "";
  }

  private fill(): void {
    const answer = this.asker.answer(Operation.Reading);
    if (answer?.state !== AnswerState.Done || answer.request === this.filled || answer.channel !== this.place()) return;
    this.filled = answer.request;
    this.where.value = "";
    const [datum_rad = 0, sigma_rad = 0] = answer.value;
    if (sigma_rad <= 0) return;
    this.datum.value = (datum_rad / kDegree).toFixed(2);
    this.sigma.value = Math.max(0.01, Math.ceil(100 * sigma_rad / kDegree) / 100).toFixed(2);
  }

  private ask(what: number, angle_rad: number): void {
    if (what === kBegin) this.forget();
    this.asker.ask(Operation.Reading, {channel: this.place(), value: [angle_rad, what]});
  }
}
