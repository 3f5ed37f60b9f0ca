// How long the car was driven in each class of speed, how fast each wheel turns now, and whether wheels drift apart.
import {rotationHz} from "./channels";
import type {Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import type {Plot, Scene, Table} from "./plot";
import type {Wish} from "./plot_ask";
import {speedNumber, speedUnit} from "./units";
import {kWheelNames} from "./wheel_place";

/** More than this by another wheel's turns, over the drive, lets their unbalances be told apart: words say so, not this. */
const kTurn = 360;

export interface SpeedClass {
  readonly speed_m_s: number;
  readonly seconds: number;
}

export function speedClasses(car: Car): SpeedClass[] {
  const known = car.identification?.message;
  if (!known) return [];
  return Array.from({length: known.speed_classes}, (_, k) => ({speed_m_s: known.speed_m_s[k] ?? NaN, seconds: known.speed_seconds[k] ?? 0}))
    .sort((a, b) => a.speed_m_s - b.speed_m_s);
}

/** By how much faster than the mean of all a wheel turns, as a share; nothing where it is not known. */
export function slips(rotation_hz: readonly (number | undefined)[]): (number | undefined)[] {
  const known = rotation_hz.filter((hz): hz is number => hz !== undefined);
  const mean = known.reduce((sum, hz) => sum + hz, 0) / known.length;
  return rotation_hz.map((hz) => (hz === undefined || known.length < 2 || !(Math.abs(mean) > 0.1) ? undefined : hz / mean - 1));
}

function cells(tag: "th" | "td", texts: readonly string[]): HTMLElement[] {
  return texts.map((text) => el(tag, tag === "th" ? {scope: "col"} : {}, [text]));
}

export class SpeedPlot implements Plot {
  readonly id = "speed";
  readonly title = "Speed classes";
  readonly isSpectral = false;
  readonly element: HTMLElement;
  private readonly speedHead = el("th", {scope: "col"});
  private readonly classes = el("tbody");
  private readonly wheels = el("tbody");
  private readonly caption = el("p", {class: "caption", id: "speed-caption"});
  private shown: readonly SpeedClass[] = [];

  constructor() {
    this.element = el("section", {class: "plot"}, [
      el("div", {class: "tables"}, [
        el("table", {id: "speed-classes"}, [
          el("caption", {}, ["Driving used by the identification"]),
          el("thead", {}, [el("tr", {}, [this.speedHead, ...cells("th", ["Seconds", "Share"])])]), this.classes]),
        el("table", {id: "speed-wheels"}, [
          el("caption", {}, ["Wheels now"]),
          el("thead", {}, [el("tr", {}, cells("th", ["Wheel", "Turns a second", "Against the mean", "Drift against another wheel"]))]),
          this.wheels])]),
      this.caption]);
  }

  wish(): Wish {
    return {};
  }

  draw({car}: Scene): void {
    this.shown = speedClasses(car);
    const total = this.shown.reduce((sum, {seconds}) => sum + seconds, 0);
    const longest = Math.max(1, ...this.shown.map(({seconds}) => seconds));
    setText(this.speedHead, `Speed, ${speedUnit()}`);
    rows(this.classes, this.shown.map(({speed_m_s, seconds}) => [
      speedNumber(speed_m_s).toFixed(1), seconds.toFixed(0), `${(100 * seconds / total).toFixed(0)} %`]), (row, k) => {
      const bar = row.querySelector<HTMLElement>(".occupancy") ?? el("div", {class: "occupancy"});
      if (!bar.parentElement) row.lastElementChild?.append(bar);
      bar.style.width = `${(100 * (this.shown[k]?.seconds ?? 0) / longest).toFixed(1)}%`;
    });
    const hz = kWheelNames.map((_, wheel) => rotationHz(car, wheel));
    const slip = slips(hz);
    rows(this.wheels, kWheelNames.map((name, wheel) => {
      const drift = car.balance.get(wheel)?.message.phase_drift_rad ?? NaN;
      return [name, hz[wheel]?.toFixed(2) ?? "not known", slip[wheel] === undefined ? "–" : `${(100 * slip[wheel]).toFixed(2)} %`,
              Number.isFinite(drift) ? `${(drift * kTurn / (2 * Math.PI)).toFixed(0)}°` : "not known"];
    }));
    setText(this.caption, this.shown.length === 0 ? "No driving has been used yet: the identification needs a record and a steady speed."
      : `${total.toFixed(0)} s of driving used. The drift is the least by which a wheel turned against another: without it ` +
        "their unbalances cannot be told apart.");
  }

  table(): Table {
    return {head: [`speed ${speedUnit()}`, "seconds"],
            columns: [this.shown.map(({speed_m_s}) => speedNumber(speed_m_s)), this.shown.map(({seconds}) => seconds)]};
  }

  canvases(): HTMLCanvasElement[] {
    return [];
  }

  captions(): string[] {
    return [...this.shown.map(({speed_m_s, seconds}) => `${speedNumber(speed_m_s).toFixed(1)} ${speedUnit()}: ${seconds.toFixed(0)} s`),
            this.caption.textContent ?? ""];
  }
}

/** The texts in the rows of a table's body; touches only what changes. */
function rows(body: HTMLElement, texts: readonly (readonly string[])[], also: (row: HTMLElement, k: number) => void = () => {}): void {
  while (body.children.length > texts.length) body.lastElementChild?.remove();
  while (body.children.length < texts.length) body.append(el("tr"));
  texts.forEach((columns, k) => {
    const row = body.children[k] as HTMLElement;
    while (row.children.length < columns.length) row.append(el("td", {}, [el("span")]));
    columns.forEach((text, c) => setText(row.children[c]?.firstElementChild as Element, text));
    setAttributes(row, {"data-row": k});
    also(row, k);
  });
}
