// The driver's view: is it recording, what to do now, the progress of each wheel.  Its only button leads back.
import type {Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import {ProgressRing} from "./progress_ring";
import {lamps, type Light} from "./lamps";
import {stateWord, warnings, type Connection} from "./state";
import {mass} from "./units";
import type {View} from "./view";
import {kWheelNames} from "./wheel_place";
import {AlarmLevel, Unknown, WeightCheckVerdict} from "./wire";
import {duration, progress, reason, verdictOf} from "./words";

class Corner {
  private readonly ring = new ProgressRing();
  private readonly grams = el("span", {class: "grams"});
  private readonly sigma = el("span", {class: "sigma"});
  private readonly verdict = el("span", {class: "verdict"});
  readonly element: HTMLElement;

  constructor(private readonly wheel: number, name: string) {
    this.element = el("div", {class: "corner", "aria-label": name}, [
      this.ring.element, el("div", {}, [el("h3", {}, [name]), this.grams, this.sigma, this.verdict])]);
  }

  draw(car: Car): void {
    const balance = car.balance.get(this.wheel)?.message;
    const known = balance?.state === Unknown.None;
    const check = car.weightCheckOf(this.wheel), [verdict = ""] = verdictOf(check).split(/[:,]| than/);
    const how = progress(balance, car.advice(this.wheel), car.identification?.message);
    // A wheel that is known well may still be bad: no tick if its weights have not helped.
    const isHelped = verdict === "" || ![WeightCheckVerdict.Unchanged, WeightCheckVerdict.More].includes(check?.verdict ?? 0);
    this.ring.draw(how, isHelped);
    setAttributes(this.element, {"data-known": String(known), "data-verdict": verdict && (WeightCheckVerdict[check?.verdict ?? 0] ?? "")});
    setText(this.verdict, verdict);
    setText(this.grams, known && balance ? mass(balance.unbalance_g) : "?");
    setText(this.sigma, known && balance ? ` ±\u00a0${mass(balance.sigma_g)}` : "");
  }
}

/** The worst that a lamp or a warning says; empty: nothing. */
export function worry(car: Car, nowMs: number): string {
  const all = lamps(car, car.events, nowMs);
  const lit = (wanted: Light, level: AlarmLevel) =>
    all.filter(({light}) => light === wanted).map(({name, number}) => ({level, text: `${name}: ${number}`}));
  const said = [...lit("bad", AlarmLevel.Alarm), ...warnings(car, nowMs), ...lit("warn", AlarmLevel.Warning)];
  return said.sort((a, b) => b.level - a.level)[0]?.text ?? "";
}

/** One thing to do now, of whatever is in the way of most wheels. */
export function whatNow(car: Car): string {
  const identification = car.identification?.message;
  const balances = [...car.balance.values()].map(({message}) => message);
  const unknown = balances.find(({state}) => state !== Unknown.None);
  if (balances.length === 0) return "Drive steadily.";
  if (unknown) return `${reason(unknown.state, identification)}.`.replace(/^./, (first) => first.toUpperCase());
  const plans = kWheelNames.flatMap((_, wheel) => car.advice(wheel) ?? []);
  if (plans.length < kWheelNames.length) return "Drive steadily.";
  const open = plans.filter(({seconds_wanted}) => seconds_wanted > 0);
  if (open.length === 0) return "Done: every wheel is known.";
  const seconds = open.map(({seconds_wanted}) => seconds_wanted).filter(Number.isFinite);
  const others = open.filter(({seconds_wanted}) => !Number.isFinite(seconds_wanted)).map(({wheel}) => kWheelNames[wheel]);
  return [...(seconds.length > 0 ? [`Drive on like this: ${Math.ceil(Math.max(...seconds))} s more.`] : []),
          ...(others.length > 0 ? [`Other speeds are needed for ${others.join(", ")}.`] : [])].join(" ");
}

export class DriverView implements View {
  readonly id = "driver";
  readonly title = "Driver";
  readonly key = "D";
  readonly does = "driver's view: large, nothing to press; Escape or a tap leaves it";
  readonly coversAll = true;
  readonly keys;
  readonly element: HTMLElement;
  private readonly word = el("span", {class: "word"});
  private readonly time = el("span", {class: "time"});
  private readonly detail = el("p", {class: "detail"});
  private readonly worry = el("p", {class: "worry", role: "status"});
  private readonly now = el("p", {class: "now"});
  private readonly corners = kWheelNames.map((name, wheel) => new Corner(wheel, name));
  private readonly state = el("p", {class: "state"}, [this.word, " ", this.time]);

  constructor(private readonly car: Car, private readonly connection: () => Connection, back: () => void) {
    this.keys = [{key: "Escape", does: "back from the driver's view", run: back}];
    this.element = el("section", {class: "driver"}, [
      this.state, this.detail, this.worry, this.now, el("div", {class: "corners"}, this.corners.map(({element}) => element))]);
    this.element.onclick = back;
  }

  draw(nowMs: number): void {
    const {alarm, word, detail, recordingS} = stateWord(this.car, this.connection(), nowMs);
    setAttributes(this.state, {"data-alarm": alarm});
    setText(this.word, word);
    setText(this.time, recordingS === undefined ? "" : duration(recordingS));
    setText(this.detail, alarm === "bad" ? detail : "");
    setText(this.worry, worry(this.car, nowMs));
    this.worry.hidden = this.worry.textContent === "";
    setText(this.now, alarm === "bad" ? "" : whatNow(this.car));
    for (const corner of this.corners) corner.draw(this.car);
  }
}
