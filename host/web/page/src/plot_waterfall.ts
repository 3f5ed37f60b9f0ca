// Amplitudes of a channel over orders of a wheel and the car's speed.
import {accelerations, carrierOf, channelName} from "./channels";
import {mapColour} from "./colour_map";
import {el, setAttributes, setText} from "./dom";
import type {Plot, Scene, Table} from "./plot";
import type {Wish} from "./plot_ask";
import {Choice, ChannelChoice} from "./plot_choice";
import {waterfallKey} from "./plot_data";
import {colour, figures, onTheme} from "./plot_figure";
import {speedNumber, speedUnit} from "./units";
import {kWheelNames} from "./wheel_place";
import {OrderState, type Waterfall} from "./wire";

const kHeight = 400, kLeft = 70, kRight = 90, kTop = 12, kBottom = 46;
const kFont = '13px system-ui, "DejaVu Sans", sans-serif';
const kDecades = 3;
// A new reason of the analyser does not compile before it has its sentence here.
const kReasons: Readonly<Record<OrderState, string>> = {
  [OrderState.Computed]: "",
  [OrderState.TooShort]: "Nothing yet: it takes 32 turns above 27 km/h (17 mph) with the wheel's angle known.",
  [OrderState.NoChannel]: "The wheel has no encoder, or the channel is no acceleration.",
  [OrderState.TooMuch]: "Others look at as many of these as the analyser computes at a time.",
};

export class WaterfallPlot implements Plot {
  readonly id = "waterfall";
  readonly title = "Orders over speed";
  readonly isSpectral = false;
  readonly element: HTMLElement;
  private readonly wheel: Choice<string>;
  private readonly channel: ChannelChoice;
  private readonly highest: Choice<string>;
  private readonly canvas = el("canvas", {class: "own-canvas", tabindex: "0",
                                          "aria-label": "Amplitude over orders and speed: arrow keys move the cursor"});
  private readonly reading = el("p", {class: "reading", id: "waterfall-reading"});
  private readonly caption = el("p", {class: "caption", id: "waterfall-caption"});
  private rows: readonly Waterfall[] = [];
  private cursor: {order: number; row: number} | undefined;

  constructor(changed: () => void) {
    this.wheel = new Choice<string>("waterfall-wheel", "Wheel", Object.fromEntries(kWheelNames.map((name, k) => [k, name])), "0", changed);
    this.channel = new ChannelChoice("waterfall-channel", "Channel", changed);
    this.highest = new Choice<string>("waterfall-highest", "Up to order", {"2": "2", "4": "4", "8": "8"}, "4", changed);
    onTheme(() => this.paint());
    this.canvas.onkeydown = (event) => this.move(event);
    this.canvas.onpointermove = this.canvas.onpointerdown = (event) => this.point(event);
    this.element = el("section", {class: "plot", id: "waterfall-plot"}, [
      el("div", {class: "choices"}, [this.wheel.element, this.channel.element, this.highest.element]),
      this.canvas, this.reading, this.caption]);
  }

  wish(): Wish {
    const channel = this.channel.value;
    return channel ? {waterfalls: [{wheel: Number(this.wheel.value), channel}]} : {};
  }

  draw({car}: Scene): void {
    const wheel = Number(this.wheel.value);
    const all = accelerations(car);
    this.channel.offer(car, all, carrierOf(car, wheel) ?? all[0]);
    const channel = this.channel.value;
    const told = channel ? car.plots.waterfalls.get(waterfallKey(wheel, channel)) : undefined;
    this.rows = [...(told?.values() ?? [])].filter(({lines}) => lines > 0).sort((a, b) => a.speed_class - b.speed_class);
    const why = told?.get(-1);
    setAttributes(this.element, {"data-classes": this.rows.length});
    const [row] = this.rows;
    setText(this.caption, row && channel
      ? `${channelName(car, channel)}, ${kWheelNames[wheel]} wheel: amplitude (peak) of each order in classes of speed, ` +
        `flat-top window over 32 turns; lines ${figures(row.step)} apart, noise bandwidth ${figures(row.noise_bandwidth)} orders.`
      : why ? kReasons[why.state as OrderState] ?? "Not known." : "The analyser has not answered yet.");
    this.paint();
  }

  private paint(): void {
    const width = this.canvas.clientWidth, scale = devicePixelRatio;
    if (width === 0) return;
    const [w, h] = [Math.round(width * scale), Math.round(kHeight * scale)];
    if (this.canvas.width !== w || this.canvas.height !== h) [this.canvas.width, this.canvas.height] = [w, h];
    const ctx = this.canvas.getContext("2d") as CanvasRenderingContext2D;
    ctx.setTransform(scale, 0, 0, scale, 0, 0);
    ctx.fillStyle = colour("--ground");
    ctx.fillRect(0, 0, width, kHeight);
    const {speed, top_decade} = this.ranges();
    const highest = Number(this.highest.value);
    const x = (order: number) => kLeft + order / highest * (width - kLeft - kRight);
    const y = (at: number) => kHeight - kBottom - (at - speed[0]) / (speed[1] - speed[0]) * (kHeight - kTop - kBottom);
    for (const row of this.rows) {
      const [from, to] = [y(speedNumber(row.to_m_s)), y(speedNumber(row.from_m_s))];
      for (let k = 0; k < row.lines && k * row.step <= highest; ++k) {
        const share = (Math.log10(Math.max(row.amplitude[k] ?? 0, 1e-12)) - top_decade + kDecades) / kDecades;
        ctx.fillStyle = `rgb(${mapColour(share).join(" ")})`;
        const left = Math.max(kLeft, x((k - 0.5) * row.step)), right = Math.min(width - kRight, x((k + 0.5) * row.step));
        ctx.fillRect(left, from, right - left + 0.7, to - from + 0.5);
      }
    }
    this.axes(ctx, width, x, y, speed, top_decade);
    this.drawCursor(ctx, x, y);
  }

  /** Speeds in the unit that is shown, and the decade on top of the colours. */
  private ranges(): {readonly speed: readonly [number, number]; readonly top_decade: number} {
    const [first] = this.rows, last = this.rows.at(-1);
    const speed: [number, number] = first && last ? [speedNumber(first.from_m_s), speedNumber(last.to_m_s)] : [0, 150];
    // At standstill there are no orders.
    const most = Math.max(1e-3, ...this.rows.flatMap(({amplitude, lines, step}) => amplitude.slice(Math.ceil(0.25 / step), lines)));
    return {speed, top_decade: Math.ceil(Math.log10(most))};
  }

  private axes(ctx: CanvasRenderingContext2D, width: number, x: (order: number) => number, y: (speed: number) => number,
               speed: readonly [number, number], top_decade: number): void {
    ctx.fillStyle = colour("--text");
    ctx.strokeStyle = colour("--line");
    ctx.lineWidth = 1;
    ctx.font = kFont;
    ctx.strokeRect(kLeft, kTop, width - kLeft - kRight, kHeight - kTop - kBottom);
    ctx.textAlign = "center";
    const highest = Number(this.highest.value);
    for (let order = 0; order <= highest; order += highest > 4 ? 1 : 0.5) {
      ctx.fillText(String(order), x(order), kHeight - kBottom + 18);
      ctx.strokeRect(x(order), kHeight - kBottom, 0, 5);
    }
    ctx.fillText("Order of the wheel", (kLeft + width - kRight) / 2, kHeight - 8);
    ctx.textAlign = "right";
    const step = speed[1] - speed[0] > 60 ? 20 : 10;
    for (let at = Math.ceil(speed[0] / step) * step; at <= speed[1] + 0.01; at += step)
      ctx.fillText(at.toFixed(0), kLeft - 8, y(at) + 4);
    ctx.save();
    ctx.translate(16, (kTop + kHeight - kBottom) / 2);
    ctx.rotate(-Math.PI / 2);
    ctx.textAlign = "center";
    ctx.fillText(`Speed, ${speedUnit()}`, 0, 0);
    ctx.restore();
    const barTop = kTop + 20, bar = kHeight - kBottom - barTop;
    for (let k = 0; k < bar; ++k) {
      ctx.fillStyle = `rgb(${mapColour(1 - k / bar).join(" ")})`;
      ctx.fillRect(width - kRight + 18, barTop + k, 14, 1.5);
    }
    ctx.fillStyle = colour("--text");
    ctx.textAlign = "left";
    ctx.fillText("m/s²", width - kRight + 18, kTop + 10);
    for (let k = 0; k <= kDecades; ++k)
      ctx.fillText(figures(10 ** (top_decade - k)), width - kRight + 38, barTop + 4 + bar * k / kDecades);
  }

  private drawCursor(ctx: CanvasRenderingContext2D, x: (order: number) => number, y: (speed: number) => number): void {
    const row = this.cursor && this.rows[this.cursor.row];
    if (!this.cursor || !row) {
      setText(this.reading, "");
      return;
    }
    const line = Math.min(row.lines - 1, Math.round(this.cursor.order / row.step));
    const middle = y(speedNumber((row.from_m_s + row.to_m_s) / 2));
    ctx.lineWidth = 2;
    for (const [stroke, radius] of [["#000", 8], ["#fff", 6]] as const) {
      ctx.strokeStyle = stroke;
      ctx.beginPath();
      ctx.arc(x(line * row.step), middle, radius, 0, 2 * Math.PI);
      ctx.stroke();
    }
    setText(this.reading, `order ${(line * row.step).toFixed(3)} at ${speedNumber(row.from_m_s).toFixed(0)} to ` +
      `${speedNumber(row.to_m_s).toFixed(0)} ${speedUnit()}: ${figures(row.amplitude[line] ?? 0)} m/s² (peak), ${row.blocks} blocks`);
  }

  private point(event: PointerEvent): void {
    const {left, top, width} = this.canvas.getBoundingClientRect();
    const {speed} = this.ranges();
    const order = (event.clientX - left - kLeft) / (width - kLeft - kRight) * Number(this.highest.value);
    const at = speed[0] + (kHeight - kBottom - (event.clientY - top)) / (kHeight - kTop - kBottom) * (speed[1] - speed[0]);
    const row = this.rows.findIndex(({from_m_s, to_m_s}) => speedNumber(from_m_s) <= at && at < speedNumber(to_m_s));
    this.cursor = row >= 0 && order >= 0 && order <= Number(this.highest.value) ? {order, row} : undefined;
    this.paint();
  }

  private move(event: KeyboardEvent): void {
    const [row] = this.rows;
    const by = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key];
    if (!by || !row || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const from = this.cursor ?? {order: 1, row: 0};
    const [across = 0, up = 0] = by;
    const order = from.order + across * row.step * (event.shiftKey ? 8 : 1);
    this.cursor = {order: Math.min(Number(this.highest.value), Math.max(0, order)),
                   row: Math.min(this.rows.length - 1, Math.max(0, from.row + up))};
    this.paint();
  }

  table(): Table {
    const [row] = this.rows;
    if (!row) return {head: [], columns: []};
    const most = Math.max(...this.rows.map(({lines}) => lines));
    return {
      head: ["order", ...this.rows.map(({from_m_s, to_m_s}) => `${speedNumber(from_m_s).toFixed(1)}..${speedNumber(to_m_s).toFixed(1)} ${speedUnit()} m/s2 peak`)],
      columns: [Array.from({length: most}, (_, k) => k * row.step), ...this.rows.map(({amplitude, lines}) => amplitude.slice(0, lines))]};
  }

  canvases(): HTMLCanvasElement[] {
    return [this.canvas];
  }

  captions(): string[] {
    return [this.reading.textContent ?? "", this.caption.textContent ?? ""];
  }
}
