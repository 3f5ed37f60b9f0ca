// An x-y plot by uPlot: curves over one axis, a cursor for mouse, finger and keys, markers, and readings of the cursor.
import uPlot from "uplot";
import {el, setText} from "./dom";

export interface Curve {
  readonly name: string;
  /** Which of the colours --curve-1 .. of style.css. */
  readonly colour: number;
  readonly x: readonly number[];
  /** null: a hole. */
  readonly y: readonly (number | null)[];
  readonly dashed?: boolean;
  /** Fills from this curve to the one before it. */
  readonly band?: boolean;
  /** Only its band is seen. */
  readonly faint?: boolean;
  /** The scale need not hold it. */
  readonly mayLeave?: boolean;
  /** Not in the list that the cursor reads. */
  readonly silent?: boolean;
}

export interface Marker {
  readonly x: number;
  readonly label: string;
}

export interface FigureOptions {
  readonly id: string;
  readonly label: string;
  readonly xLabel: string;
  /** Of the room that plots have on the screen. */
  readonly share: number;
  readonly logarithmic?: boolean;
  readonly range?: readonly [number, number];
  /** A band is drawn as a bar for each of its values, and no line: cheap where it swings widely. */
  readonly bars?: boolean;
  /** Where the y axis has its numbers. */
  readonly splits?: readonly number[];
  /** Figures of one name share their cursor. */
  readonly together?: string;
  /** Where the cursor is, for people. */
  readonly xText: (x: number) => string;
}

/** What is beside figures in the view of plots, and how high all are together at the least and the most. */
const kBeside = 163, kLeastHeight = 280, kMostHeight = 800;
function figureHeight(share: number): number {
  const above = document.querySelector<HTMLElement>(".plots")?.offsetTop ?? 0;
  return Math.round(share * Math.min(kMostHeight, Math.max(kLeastHeight, innerHeight - above - kBeside)));
}

export const kColours = 6;
const kFont = '13px system-ui, "DejaVu Sans", sans-serif';
const kKeyStep = 4, kKeyLeap = 40;  // pixels

let theme = "";
const colours = new Map<string, string>();
/** Of style.css, as the theme has it. */
export function colour(name: string): string {
  const now = document.documentElement.dataset["theme"] ?? "";
  if (now !== theme) colours.clear();
  theme = now;
  let found = colours.get(name);
  if (found === undefined) colours.set(name, found = getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return found;
}
/** What is painted on a canvas has to be painted again, frozen or not. */
export function onTheme(repaint: () => void): void {
  new MutationObserver(repaint).observe(document.documentElement, {attributes: true, attributeFilter: ["data-theme"]});
}
export const curveColour = (k: number) => colour(`--curve-${1 + k % kColours}`);

/** Three digits, and a power of ten only where they would not do. */
export function figures(value: number): string {
  const size = Math.abs(value);
  if (size === 0) return "0";
  const short = Number(value.toPrecision(3));
  return size >= 1e-3 && size < 1e5 ? String(short) : short.toExponential();
}

export class Figure {
  readonly element: HTMLElement;
  private readonly box = el("div", {class: "figure-box", tabindex: "0"});
  readonly reading = el("p", {class: "reading"});
  private plot: uPlot | undefined;
  private shape = "";
  private curves: readonly Curve[] = [];
  private markers: readonly Marker[] = [];
  private yLabel = "";
  private logarithmic: boolean;

  constructor(private readonly options: FigureOptions) {
    this.logarithmic = options.logarithmic ?? false;
    this.box.setAttribute("aria-label", `${options.label}: arrow keys move the cursor`);
    this.element = el("figure", {class: "figure", id: options.id}, [this.box, this.reading]);
    this.box.onkeydown = (event) => this.move(event);
    new ResizeObserver(() => this.resize()).observe(this.box);
    addEventListener("resize", () => this.resize());
    onTheme(() => this.plot?.redraw(false));
  }

  /** What it shows at present. */
  shown(): readonly Curve[] {
    return this.curves;
  }

  canvas(): HTMLCanvasElement | undefined {
    return this.plot?.ctx.canvas;
  }

  text(): string {
    return this.reading.textContent ?? "";
  }

  /** Draws only what is new: arrays that are the same ones are taken for unchanged. */
  show(curves: readonly Curve[], yLabel: string, markers: readonly Marker[] = [], xRange?: readonly [number, number],
       logarithmic = this.options.logarithmic ?? false): void {
    const isKnown = isSameList(curves, this.curves, (a, b) => a.x === b.x && a.y === b.y);
    const isMarked = isSameList(markers, this.markers, (a, b) => a.x === b.x && a.label === b.label);
    this.curves = curves;
    this.markers = markers;
    if (this.box.clientWidth === 0) return;
    const shape = JSON.stringify([curves.map(({name, colour: k, dashed, band}) => [name, k, dashed, band]), yLabel, logarithmic]);
    this.logarithmic = logarithmic;
    this.yLabel = yLabel;
    if (!this.plot || shape !== this.shape) {
      this.shape = shape;
      this.make(this.data());
    } else if (isKnown) {
      if (!isMarked) this.plot.redraw(false);
      return;
    } else {
      this.plot.setData(this.data(), true);
    }
    if (xRange && xRange[1] > xRange[0]) this.plot?.setScale("x", {min: xRange[0], max: xRange[1]});
    this.read();
  }

  private data(): uPlot.AlignedData {
    const clean = (y: readonly (number | null)[]) =>
      (this.logarithmic ? y.map((value) => (value !== null && value > 0 ? value : null)) : [...y]);
    const [first] = this.curves;
    if (!first) return [[]];
    if (this.curves.every(({x}) => isSame(x, first.x))) return [[...first.x], ...this.curves.map(({y}) => clean(y))];
    return uPlot.join(this.curves.map(({x, y}): uPlot.AlignedData => [[...x], clean(y)]),
                      this.curves.map(() => [0, 2]));
  }

  private make(data: uPlot.AlignedData): void {
    const left = this.plot?.cursor.left ?? -10;
    this.plot?.destroy();
    const axis = (label: string, size: number): uPlot.Axis => ({
      label, size, labelSize: 18, gap: 4, font: kFont, labelFont: kFont, labelGap: 0,
      stroke: () => colour("--text"), grid: {stroke: () => colour("--grid"), width: 1},
      ticks: {stroke: () => colour("--grid"), width: 1, size: 5},
    });
    const {range, splits, bars, together, share, xLabel} = this.options;
    const isLast = xLabel !== "";  // the plots above it show no numbers
    this.plot = new uPlot({
      width: this.box.clientWidth, height: figureHeight(share),
      legend: {show: false},
      cursor: {
        drag: {x: false, y: false}, points: {size: 7},
        ...(together ? {sync: {key: together, setSeries: false}} : {}),
      },
      scales: {
        x: {time: false},
        y: range ? {range: [range[0], range[1]]} : this.logarithmic ? {distr: 3, log: 10} : {},
      },
      axes: [
        isLast ? axis(xLabel, 30) : {...axis("", 8), labelSize: 0, values: (_, at) => at.map(() => "")},
        {...axis(this.yLabel, 62), ...(splits ? {splits: [...splits]} : {}),
         values: (_, splits) => splits.map((value) => (value === null ? "" : figures(value)))}],
      series: [{}, ...this.curves.map((curve): uPlot.Series => ({
        label: curve.name, width: curve.faint ? 0 : curve.dashed ? 1 : 1.5, spanGaps: false,
        auto: !curve.mayLeave, ...(bars ? {paths: () => null} : {}), stroke: () => curveColour(curve.colour), ...(curve.dashed ? {dash: [6, 4]} : {}), points: {show: false},
      }))],
      bands: this.curves.flatMap(({band, colour: k}, at) =>
        (band && !bars ? [{series: [at + 1, at] as [number, number], fill: () => `${curveColour(k)}66`}] : [])),
      hooks: {draw: [(plot) => this.drawBars(plot), (plot) => this.drawMarkers(plot)], setCursor: [() => this.read()]},
    }, data, this.box);
    if (left >= 0) this.plot.setCursor({left, top: 10});
  }

  private drawBars(plot: uPlot): void {
    if (!this.options.bars) return;
    const {ctx, bbox} = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.globalAlpha = 0.8;
    this.curves.forEach(({band, colour: k}, at) => {
      const xs = plot.data[0], ends = plot.data[at + 1], begins = plot.data[at];
      if (!band || !ends || !begins || xs.length < 2) return;
      const width = Math.max(1, plot.valToPos(xs[1] ?? 0, "x", true) - plot.valToPos(xs[0] ?? 0, "x", true));
      ctx.fillStyle = curveColour(k);
      for (let i = 0; i < xs.length; ++i) {
        const [from, to] = [begins[i], ends[i]];
        if (from === null || from === undefined || to === null || to === undefined) continue;
        const top = plot.valToPos(to, "y", true);
        const height = Math.max(devicePixelRatio, plot.valToPos(from, "y", true) - top);
        ctx.fillRect(Math.round(plot.valToPos(xs[i] ?? 0, "x", true) - width / 2), top, Math.ceil(width), height);
      }
    });
    ctx.restore();
  }

  private drawMarkers(plot: uPlot): void {
    const {ctx, bbox} = plot;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colour("--spot");
    ctx.lineWidth = devicePixelRatio;
    ctx.textAlign = "left";
    ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
    ctx.font = `600 ${12 * devicePixelRatio}px system-ui, "DejaVu Sans", sans-serif`;
    for (const {x, label} of this.markers) {
      const at = plot.valToPos(x, "x", true);
      if (!(at >= bbox.left && at <= bbox.left + bbox.width)) continue;
      ctx.beginPath();
      ctx.moveTo(at, bbox.top);
      ctx.lineTo(at, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText(label, at + 3 * devicePixelRatio, bbox.top + 12 * devicePixelRatio);
    }
    ctx.restore();
  }

  private resize(): void {
    const height = figureHeight(this.options.share), width = this.box.clientWidth;
    if (this.plot && width > 0 && (width !== this.plot.width || height !== this.plot.height)) this.plot.setSize({width, height});
  }

  private move(event: KeyboardEvent): void {
    const by = {ArrowLeft: -1, ArrowRight: 1}[event.key];
    if (by === undefined || !this.plot || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const width = this.plot.over.clientWidth;
    const from = (this.plot.cursor.left ?? -1) >= 0 ? this.plot.cursor.left ?? 0 : width / 2;
    const left = Math.min(width - 1, Math.max(0, from + by * (event.shiftKey ? kKeyLeap : kKeyStep)));
    this.plot.setCursor({left, top: this.plot.over.clientHeight / 2}, true);
  }

  /** Says what the curves are at the cursor. */
  private read(): void {
    const {plot} = this;
    if (!plot) return;
    const index = (plot.cursor.left ?? -1) >= 0 ? plot.cursor.idx : null;
    const x = index === null || index === undefined ? undefined : plot.data[0][index];
    const loud = this.curves.map((curve, k) => ({curve, k})).filter(({curve}) => !curve.silent);
    while (this.reading.children.length > loud.length + 1) this.reading.lastElementChild?.remove();
    while (this.reading.children.length < loud.length + 1) this.reading.append(el("span"));
    setText(this.reading.children[0] as Element, x === undefined ? "" : this.options.xText(x));
    loud.forEach(({curve, k}, place) => {
      const span = this.reading.children[place + 1] as HTMLElement;
      const value = x === undefined ? undefined : nearest(plot, k + 1, index ?? 0);
      setText(span, `${curve.dashed ? "┄" : "━"} ${curve.name}${value === undefined ? "" : ` ${figures(value)}`}`);
      span.style.color = `var(--curve-${1 + curve.colour % kColours})`;
    });
  }
}

const isSameList = <T>(a: readonly T[], b: readonly T[], same: (a: T, b: T) => boolean) =>
  a.length === b.length && a.every((value, k) => same(value, b[k] as T));

/** Steps are even in all that is plotted. */
const isSame = (a: readonly number[], b: readonly number[]) =>
  a === b || (a.length === b.length && a[0] === b[0] && a.at(-1) === b.at(-1));

/** Of a series that may have values at other places only. */
function nearest(plot: uPlot, series: number, index: number): number | undefined {
  const values = plot.data[series];
  for (let by = 0; values && by < 16; ++by)
    for (const at of [index - by, index + by]) {
      const value = values[at];
      if (value !== null && value !== undefined) return value;
    }
  return undefined;
}
