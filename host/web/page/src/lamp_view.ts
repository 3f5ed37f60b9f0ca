// The four lamps; a tap on one shows its meaning and the remedy.
import {levelOf, levelSign, levelWord} from "./alarm";
import type {Car} from "./car";
import {el, setAttributes, setText, svg} from "./dom";
import type {LampName} from "./events";
import {lamps, sentenceOf, type Light} from "./lamps";
import {kCross, kDisc, kLine, kTriangle} from "./signs";
import {AlarmLevel} from "./wire";

const kShapes: Readonly<Record<Light, string>> = {
  good: kDisc,
  unknown: kLine,
  warn: kTriangle,
  bad: kCross,
};

/** The level, as a word. */
const kSpoken: Readonly<Record<Light, string>> = {
  good: "", unknown: "", warn: `, ${levelWord(AlarmLevel.Warning)}`, bad: `, ${levelWord(AlarmLevel.Alarm)}`};

class LampButton {
  readonly shape = svg("path");
  readonly number = el("span", {class: "number"});
  readonly element: HTMLButtonElement;

  constructor(name: string, open: () => void) {
    this.element = el("button", {class: "lamp", type: "button", id: `lamp-${name}`, "aria-expanded": "false"}, [
      svg("svg", {viewBox: "0 0 16 16", "aria-hidden": "true"}, [this.shape]), el("span", {class: "name"}, [name]), this.number]);
    this.element.onclick = open;
  }
}

export class LampView {
  readonly element: HTMLElement;
  private readonly buttons = new Map<string, LampButton>();
  private readonly sentence = el("p", {class: "sentence", role: "status"});
  private readonly events = el("ol", {class: "events", "aria-label": "Events"});
  private listed = "";
  private open: LampName | "" = "";

  constructor(private readonly car: Car) {
    const names: readonly LampName[] = ["LOSS", "SYNC", "OVERLOAD", "ENCODER"];
    for (const name of names)
      this.buttons.set(name, new LampButton(name, () => { this.open = this.open === name ? "" : name; }));
    this.element = el("section", {class: "lamps", "aria-label": "Lamps"},
                      [...[...this.buttons.values()].map(({element}) => element), this.sentence, this.events]);
  }

  acknowledge(): void {
    this.car.events.acknowledge();
    this.car.overloadMs.clear();
    this.car.clippedMs.clear();
  }

  draw(nowMs: number): void {
    let text = "";
    for (const lamp of lamps(this.car, this.car.events, nowMs)) {
      const button = this.buttons.get(lamp.name);
      if (!button) continue;
      setAttributes(button.element, {"data-light": lamp.light, "aria-expanded": String(this.open === lamp.name)});
      setAttributes(button.shape, {d: kShapes[lamp.light]});
      setText(button.number, lamp.number);
      if (this.open === lamp.name) text = `${lamp.name}${kSpoken[lamp.light]}: ${lamp.sentence}`;
    }
    setText(this.sentence, text);
    this.list(nowMs);
  }

  /** Time, place and remedy of each; those that nobody has acknowledged stand out. */
  private list(nowMs: number): void {
    const events = this.open === "" ? [] : this.car.events.of(this.open);
    const said = events.map((event) => `${event.where} ${event.count} ${event.firstMs} ${event.seen}`).join();
    if (said === this.listed) return;
    this.listed = said;
    this.events.replaceChildren(...events.map((event) => el("li", {"data-seen": String(event.seen)}, [
      levelSign(levelOf(event.cause)), el("time", {}, [new Date(Date.now() - (nowMs - event.firstMs)).toLocaleTimeString("en-GB")]),
      el("b", {}, [event.where]), el("span", {}, [sentenceOf(event)])])));
  }
}
