// First or second order of each wheel in a channel, as a vector with its region of 95 % confidence.
import {accelerations, carrierOf, channelKey, channelName, channelOfKey, type ChannelId} from "./channels";
import type {Car} from "./car";
import {el, setText} from "./dom";
import type {Plot, Scene, Table} from "./plot";
import type {Wish} from "./plot_ask";
import {Choice} from "./plot_choice";
import {colour, curveColour, figures, onTheme} from "./plot_figure";
import {kWheelNames} from "./wheel_place";

const kSize = 300, kRadius = 108;
const kFont = '13px system-ui, "DejaVu Sans", sans-serif';
const kOwn = "own";

export interface OrderVector {
  readonly re: number;
  readonly im: number;
  /** m/s²; NaN: too few blocks. */
  readonly amplitude_95: number;
  /** NaN: the phase is not known. */
  readonly phase_95_rad: number;
  readonly blocks: number;
}

/** What a wheel does in a channel; nothing if nobody has told. */
export function orderVector(car: Car, wheel: number, id: ChannelId, order: 1 | 2): OrderVector | undefined {
  const report = car.plots.orders.get(`${wheel}.${id.node}`);
  const value = report?.vector[order - 1]?.[id.channel];
  const blocks = report?.blocks[order - 1]?.[id.channel] ?? 0;
  if (!report || !value || blocks === 0) return undefined;
  const [re = NaN, im = NaN] = value;
  return {re, im, blocks, amplitude_95: report.amplitude_95[order - 1]?.[id.channel] ?? NaN,
          phase_95_rad: report.phase_95_rad[order - 1]?.[id.channel] ?? NaN};
}

/** The least of 1, 2, 5 times a power of ten that is no less. */
export function roundScale(value: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-6)));
  return power * ([1, 2, 5, 10].find((step) => step * power >= value * (1 - 1e-9)) ?? 10);
}

export class PolarPlot implements Plot {
  readonly id = "polar";
  readonly title = "Polar";
  readonly isSpectral = false;
  readonly element: HTMLElement;
  private readonly order: Choice<"1" | "2">;
  private readonly channel: Choice<string>;
  private readonly cells = kWheelNames.map((name) => ({
    name, canvas: el("canvas", {class: "own-canvas polar-canvas", role: "img", "aria-label": name}), text: el("p", {class: "polar-text"})}));
  private readonly caption = el("p", {class: "caption"}, [
    "Angles count from the wheel's reference point (the valve) in the direction of rotation; amplitudes are peaks, over the drive so far. The " +
    "filled region holds the vector with 95 %. The help (?) has the formula."]);
  private rows: (number | string | null)[][] = [];
  private reference: (OrderVector | undefined)[] = [];
  private now: (OrderVector | undefined)[] = [];
  private full = 1;

  constructor(changed: () => void) {
    onTheme(() => this.paint());
    this.order = new Choice<"1" | "2">("polar-order", "Order", {"1": "first", "2": "second"}, "1", changed);
    this.channel = new Choice<string>("polar-channel", "Channel", {[kOwn]: "upright on each wheel's carrier"}, kOwn, changed);
    this.element = el("section", {class: "plot"}, [
      el("div", {class: "choices"}, [this.order.element, this.channel.element]),
      el("div", {class: "polars"}, this.cells.map(({name, canvas, text}) =>
        el("div", {class: "polar"}, [el("h3", {}, [name]), canvas, text]))),
      this.caption]);
  }

  wish(): Wish {
    return {};
  }

  draw({car}: Scene): void {
    const all = accelerations(car);
    this.channel.offer({[kOwn]: "upright on each wheel's carrier",
                        ...Object.fromEntries(all.map((id) => [channelKey(id), channelName(car, id)]))});
    const order = Number(this.order.value) as 1 | 2;
    const ids = kWheelNames.map((_, wheel) => (this.channel.value === kOwn ? carrierOf(car, wheel) : channelOfKey(this.channel.value)));
    this.now = ids.map((id, wheel) => id && orderVector(car, wheel, id, order));
    const most = Math.max(0, ...[...this.now, ...this.reference].map((vector) => (vector ? Math.hypot(vector.re, vector.im) : 0)));
    this.full = roundScale(most);
    this.paint();
    this.rows = [];
    this.cells.forEach(({text, name}, wheel) => {
      const vector = this.now[wheel], id = ids[wheel];
      if (!vector || !id) {
        setText(text, !id ? "No node has said which channel stands upright on this wheel's carrier: choose a channel." :
          "Not known yet: it takes turns above 40 km/h with the wheel's angle known, and a record.");
        return;
      }
      const amplitude = Math.hypot(vector.re, vector.im), phase = (Math.atan2(vector.im, vector.re) * 180 / Math.PI + 360) % 360;
      const reach = Number.isFinite(vector.amplitude_95) ? ` ± ${figures(vector.amplitude_95)}` : "";
      const phaseKnown = Number.isFinite(vector.phase_95_rad);
      setText(text, `${channelName(car, id)}: ${figures(amplitude)}${reach} m/s², ` +
        (phaseKnown ? `${phase.toFixed(1)}° ± ${(vector.phase_95_rad * 180 / Math.PI).toFixed(1)}° (95 %)` : "its phase is not known") +
        `, ${vector.blocks} blocks`);
      this.rows.push([name, channelName(car, id), order, amplitude, orNull(vector.amplitude_95), phaseKnown ? phase : null,
                      orNull(vector.phase_95_rad * 180 / Math.PI), vector.blocks]);
    });
  }

  private paint(): void {
    this.cells.forEach(({canvas}, wheel) => paint(canvas, this.now[wheel], this.reference[wheel], this.full));
  }

  table(): Table {
    const head = ["wheel", "channel", "order", "amplitude m/s2 peak", "95 % m/s2", "phase_deg", "95 % deg", "blocks"];
    return {head, columns: head.map((_, k) => this.rows.map((row) => row[k] ?? null))};
  }

  canvases(): HTMLCanvasElement[] {
    return this.cells.map(({canvas}) => canvas);
  }

  captions(): string[] {
    return [...this.cells.map(({name, text}) => `${name}: ${text.textContent ?? ""}`), this.caption.textContent ?? ""];
  }

  keepReference(): void {
    this.reference = this.now;
  }

  dropReference(): void {
    this.reference = [];
  }
}

const orNull = (value: number) => (Number.isFinite(value) ? value : null);

function paint(canvas: HTMLCanvasElement, vector: OrderVector | undefined, reference: OrderVector | undefined, full: number): void {
  const scale = devicePixelRatio;
  const size = Math.round(kSize * scale);
  if (canvas.width !== size || canvas.height !== size) canvas.width = canvas.height = size;
  const ctx = canvas.getContext("2d") as CanvasRenderingContext2D;
  ctx.setTransform(scale, 0, 0, scale, kSize / 2 * scale, kSize / 2 * scale);
  ctx.fillStyle = colour("--card");
  ctx.fillRect(-kSize / 2, -kSize / 2, kSize, kSize);
  ctx.strokeStyle = colour("--line");
  ctx.lineWidth = 1;
  for (const share of [0.5, 1]) circle(ctx, share * kRadius);
  ctx.beginPath();
  ctx.moveTo(-kRadius, 0);
  ctx.lineTo(kRadius, 0);
  ctx.moveTo(0, -kRadius);
  ctx.lineTo(0, kRadius);
  ctx.stroke();
  ctx.fillStyle = colour("--quiet");
  ctx.font = kFont;
  ctx.textAlign = "center";
  for (const [text, x, y] of [["0°", kRadius + 18, 5], ["90°", 0, -kRadius - 8], ["180°", -kRadius - 20, 5], ["270°", 0, kRadius + 18]] as const)
    ctx.fillText(text, x, y);
  ctx.textAlign = "right";
  ctx.fillText(`circle = ${figures(full)} m/s²`, kSize / 2 - 4, kSize / 2 - 6);
  if (reference) arrow(ctx, reference, full, 2, true);
  if (vector) arrow(ctx, vector, full, 0, false);
}

function circle(ctx: CanvasRenderingContext2D, radius: number): void {
  ctx.beginPath();
  ctx.arc(0, 0, radius, 0, 2 * Math.PI);
  ctx.stroke();
}

function arrow(ctx: CanvasRenderingContext2D, vector: OrderVector, full: number, k: number, dashed: boolean): void {
  const unit = kRadius / full, amplitude = Math.hypot(vector.re, vector.im);
  ctx.save();
  ctx.beginPath();  // clips the drawing: it must not cover its neighbours
  ctx.rect(-kSize / 2, -kSize / 2, kSize, kSize);
  ctx.clip();
  ctx.strokeStyle = ctx.fillStyle = curveColour(k);
  ctx.setLineDash(dashed ? [5, 4] : []);
  if (!Number.isFinite(vector.phase_95_rad)) {  // it may point anywhere
    ctx.lineWidth = 2;
    circle(ctx, amplitude * unit);
    ctx.restore();
    return;
  }
  const along = vector.amplitude_95 * unit;
  const across = amplitude * vector.phase_95_rad * unit;
  ctx.save();
  ctx.rotate(-Math.atan2(vector.im, vector.re));  // canvas: y downwards
  if (Number.isFinite(along) && Number.isFinite(across)) {
    ctx.beginPath();
    ctx.ellipse(amplitude * unit, 0, Math.max(along, 1), Math.max(across, 1), 0, 0, 2 * Math.PI);
    ctx.globalAlpha = 0.4;
    ctx.fill();
    ctx.globalAlpha = 1;
    ctx.lineWidth = 1.5;
    ctx.stroke();
  }
  ctx.lineWidth = 3;
  ctx.beginPath();
  ctx.moveTo(0, 0);
  ctx.lineTo(amplitude * unit, 0);
  ctx.stroke();
  ctx.restore();
  ctx.restore();
}
