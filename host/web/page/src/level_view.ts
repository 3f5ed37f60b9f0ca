// A bar for each acceleration: rms, and the peak of the last seconds.
import {isFresh, type Car, type Heard} from "./car";
import {faultOf} from "./channel_faults";
import {el, setAttributes, setText} from "./dom";
import {speed} from "./units";
import type {Level} from "./wire";

/** Channels 13 to 16 are the wheels' references. */
export const kAccelerations = 12;
/** As in style.css. */
const kTrackPixels = 64;
/** Nobody reads numbers that change faster. */
const kNumbersMs = 250;

/** Height of a bar, 0 .. 1: four decades up to 100 m/s^2. */
export function height(acceleration_m_s2: number): number {
  return Math.min(1, Math.max(0, (Math.log10(Math.max(acceleration_m_s2, 1e-9)) + 2) / 4));
}

class Bar {
  private readonly rms = el("div", {class: "rms"});
  private readonly peak = el("div", {class: "peak"});
  private readonly number = el("span", {class: "value"});
  readonly element: HTMLElement;

  constructor(private readonly node: number, private readonly channel: number) {
    this.element = el("div", {class: "bar"}, [
      el("div", {class: "track"}, [this.rms, this.peak]), this.number, el("span", {class: "channel"}, [`${channel}`])]);
  }

  draw(car: Car, level: Level, withNumbers: boolean): void {
    const k = this.channel - 1;
    const rms = level.rms[k] ?? 0;
    const name = `${this.node}.${this.channel}`;
    const wrong = car.overloadMs.has(name) ? "OVER" : car.clippedMs.has(name) ? "CLIP" : "";
    const fault = faultOf(level, k);
    setAttributes(this.element, {"data-light": wrong ? "bad" : fault ? "warn" : "good"});
    this.rms.style.transform = `scaleY(${height(rms).toFixed(3)})`;
    const peak = height(car.peaks.get(`${this.node}.${this.channel}`)?.value ?? 0);
    this.peak.style.transform = `translateY(${(-kTrackPixels * peak).toFixed(1)}px)`;
    // Numbers that change with every frame cannot be read; words change at once.
    if (withNumbers || wrong || fault || this.number.textContent === "")
      setText(this.number, wrong || fault || rms.toPrecision(2));
  }
}

class NodeLevels {
  private readonly title = el("h3");
  private readonly bars: Bar[];
  readonly element: HTMLElement;

  constructor(private readonly node: number) {
    this.bars = Array.from({length: kAccelerations}, (_, k) => new Bar(node, k + 1));
    this.element = el("div", {class: "node"}, [this.title, el("div", {class: "bars"}, this.bars.map(({element}) => element))]);
  }

  draw(car: Car, heard: Heard<Level>, nowMs: number, withNumbers: boolean): void {
    const level = heard.message;
    const driven = Number.isFinite(level.speed_m_s) ? speed(level.speed_m_s) : "no speed";
    const old = isFresh(heard, nowMs) ? "" : ` · OLD: ${Math.round((nowMs - heard.atMs) / 1000)} s`;
    setText(this.title, `Node ${this.node} · ${driven}${old}`);
    setAttributes(this.element, {"data-old": String(old !== "")});
    for (const bar of this.bars) bar.draw(car, level, withNumbers);
  }
}

export class LevelView {
  readonly element: HTMLElement;
  private readonly nodes = new Map<number, NodeLevels>();
  private numbersAtMs = -Infinity;
  private readonly none = el("p", {}, ["No levels: no analyser is heard."]);

  constructor(private readonly car: Car) {
    this.element = el("section", {class: "levels", id: "levels"}, [
      el("h2", {}, ["Levels ", el("small", {}, ["rms in m/s², line: peak of 3 s"])]), this.none]);
  }

  draw(nowMs: number): void {
    const withNumbers = nowMs - this.numbersAtMs >= kNumbersMs;
    if (withNumbers) this.numbersAtMs = nowMs;
    this.none.hidden = this.car.levels.size > 0;
    for (const [node, view] of this.nodes)
      if (!this.car.levels.has(node)) {
        view.element.remove();
        this.nodes.delete(node);
      }
    for (const [node, heard] of [...this.car.levels].sort(([a], [b]) => a - b)) {
      let view = this.nodes.get(node);
      if (!view) {
        this.nodes.set(node, view = new NodeLevels(node));
        this.element.append(view.element);
      }
      view.draw(this.car, heard, nowMs, withNumbers);
    }
  }
}
