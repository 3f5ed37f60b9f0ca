// Spectra of channels, with a cursor and the orders of a wheel.
import {accelerations, carriers, channelKey, channelName, rotationHz, type ChannelId} from "./channels";
import type {Car} from "./car";
import {el, setText} from "./dom";
import type {Plot, Scene, Table} from "./plot";
import type {Spectral, Wish} from "./plot_ask";
import {Choice, ChannelsChoice} from "./plot_choice";
import {frequencies, joined} from "./plot_data";
import {Figure, figures, kColours, type Curve, type Marker} from "./plot_figure";
import {curvesTable} from "./plot_save";
import {kWheelNames} from "./wheel_place";
import {SpectralState, type Spectrum} from "./wire";

export type Quantity = "density" | "peak" | "rms";
const kQuantities: Readonly<Record<Quantity, string>> = {
  density: "density, (m/s²)²/Hz", peak: "amplitude (peak), m/s²", rms: "amplitude (rms), m/s²"};
export const kWindowNames = ["rectangular", "Hann", "flat top"] as const;
const kOrders = 4;
/** Of a line's amplitude, by window (F. J. Harris, Proc. IEEE 66 (1978) 51-83, table I). */
const kLow = [" A line between bins reads up to 36 % low: take the flat top.", " A line between bins reads up to 15 % low: take the flat top.", ""];

/** A line of density G is as strong as a sine of rms sqrt(G B), B the equivalent noise bandwidth; at 0 Hz is no sine, and
 * its peak is its rms. */
export function amplitude(density: number, hz: number, enbw_hz: number, quantity: Quantity): number {
  if (quantity === "density") return density;
  return Math.sqrt(density * enbw_hz * (quantity === "peak" && hz > 0 ? 2 : 1));
}

/** Where the orders of a wheel are. */
export function orderMarkers(car: Car, wheel: number): Marker[] {
  const hz = rotationHz(car, wheel);
  if (hz === undefined || hz < 0.5) return [];
  return Array.from({length: kOrders}, (_, k) => ({x: (k + 1) * hz, label: `${k + 1}×`}));
}

export const orderChoice = (id: string, changed: () => void) =>
  new Choice<string>(id, "Orders of", {"": "no wheel", ...Object.fromEntries(kWheelNames.map((name, k) => [k, name]))}, "0", changed);

/** How such spectra were made, in a sentence. */
export function spectralCaption(spectral: Spectral, part: {readonly step_hz: number; readonly enbw_hz: number}): string {
  const mean = spectral.holdPeaks ? "the greatest of each bin is held" :
    spectral.memory === 0 ? "linear average" : `exponential average over ${spectral.memory}`;
  return `${kWindowNames[spectral.window]} window, ${spectral.segment} samples, ${100 * spectral.overlap} % overlap, ${mean}; ` +
    `lines ${figures(part.step_hz)} Hz apart, equivalent noise bandwidth ${figures(part.enbw_hz)} Hz`;
}

/** A spectrum, whatever of it is shown. */
interface Density {
  readonly name: string;
  readonly colour: number;
  readonly x: readonly number[];
  readonly density: readonly number[];
  readonly enbw_hz: number;
}

/** Why there is no transfer function, or no spectrum; a reason that the analyser learns to give does not compile before it
 * has its sentence here. */
export const kReasons: Readonly<Record<SpectralState, string>> = {
  [SpectralState.Computed]: "",
  [SpectralState.TooShort]: "Not yet: a block without a gap or overload must be full first.",
  [SpectralState.NoChannel]: "The vehicle has no such channel in use.",
  [SpectralState.NoCommonTime]: "The nodes' samples do not lie on one grid of time: look at SYNC.",
  [SpectralState.TooMuch]: "The analyser holds no more: take shorter blocks or fewer channels, or close other pages.",
};

/** ", 2.0 s": how long a block takes, where the node has said how fast it samples. */
function blockTime(car: Car, id: ChannelId | undefined, {segment}: Spectral): string {
  const rate = id && car.setups.get(id.node)?.message.rate_hz;
  return rate ? `, ${(segment / rate).toFixed(1)} s` : "";
}

/** Why there is none of a channel. */
function whyNone(part: Spectrum | undefined, car: Car, id: ChannelId, spectral: Spectral): string {
  if (!part) return "the analyser has not answered yet.";
  if (part.state === SpectralState.TooShort)
    return `not yet: a block of ${spectral.segment} samples without a gap or overload must be full first${blockTime(car, id, spectral)}.`;
  return kReasons[part.state as SpectralState] ?? "not known.";
}

export class SpectrumPlot implements Plot {
  readonly id = "spectrum";
  readonly title = "Spectrum";
  readonly isSpectral = true;
  readonly element: HTMLElement;
  private readonly channels: ChannelsChoice;
  private readonly quantity: Choice<Quantity>;
  private readonly orders: Choice<string>;
  private readonly caption = el("p", {class: "caption", id: "spectrum-caption"});
  private readonly figure = new Figure({
    id: "spectrum-figure", label: "Spectrum", xLabel: "Frequency, Hz", share: 1, logarithmic: true,
    xText: (x) => `${x.toFixed(2)} Hz`});
  private now: Density[] = [];
  private reference: Density[] = [];
  private readonly known = new WeakMap<readonly Spectrum[], {readonly x: number[]; readonly density: number[]}>();
  private readonly amplitudes = new WeakMap<readonly number[], {readonly quantity: Quantity; readonly y: number[]}>();

  constructor(changed: () => void) {
    this.channels = new ChannelsChoice("spectrum-channels", kColours, changed);
    this.quantity = new Choice("spectrum-quantity", "Show", kQuantities, "density", changed);
    this.orders = orderChoice("spectrum-orders", changed);
    this.element = el("section", {class: "plot"}, [
      el("div", {class: "choices"}, [this.channels.element, this.quantity.element, this.orders.element]),
      this.figure.element, this.caption]);
  }

  wish(): Wish {
    return {spectra: this.channels.value};
  }

  /** What is chosen is not yet what is shown. */
  private drawn: Quantity = "density";

  draw({car, spectral}: Scene): void {
    this.channels.offer(car, accelerations(car), carriers(car));
    const wanted = this.channels.value;
    this.now = [];
    let about: Spectrum | undefined;
    const why: string[] = [];
    wanted.forEach((id, k) => {
      const parts = car.plots.spectra.get(channelKey(id))?.whole ?? [];
      const [part] = parts;
      if (!part || part.state !== SpectralState.Computed) {
        why.push(` ${channelName(car, id)}: ${whyNone(part, car, id, spectral)}`);
        return;
      }
      about = part;
      this.now.push({name: channelName(car, id), colour: k, enbw_hz: part.enbw_hz, ...this.numbers(parts)});
    });
    const markers = this.orders.value === "" ? [] : orderMarkers(car, Number(this.orders.value));
    const quantity = this.drawn = this.quantity.value;
    const curve = ({name, colour, x, density, enbw_hz}: Density, dashed: boolean): Curve =>
      ({name: dashed ? `${name} (reference)` : name, colour, x, dashed, y: this.shown(x, density, enbw_hz, quantity)});
    this.figure.show([...this.now.map((one) => curve(one, false)), ...this.reference.map((one) => curve(one, true))], kQuantities[this.quantity.value], markers);
    setText(this.caption, (about ? `${spectralCaption(spectral, about)}; ${about.averages} blocks.${quantity === "density" ? "" : kLow[spectral.window] ?? ""} ` : "") +
      (wanted.length === 0 ? "Choose a channel." : why.join("")));
  }

  // Computed once for each message.
  private numbers(parts: readonly Spectrum[]): {readonly x: number[]; readonly density: number[]} {
    let found = this.known.get(parts);
    if (!found) this.known.set(parts, found = {x: frequencies(parts), density: joined(parts, ({density}) => density)});
    return found;
  }

  private shown(x: readonly number[], density: readonly number[], enbw_hz: number, quantity: Quantity): readonly number[] {
    if (quantity === "density") return density;
    let found = this.amplitudes.get(density);
    if (found?.quantity !== quantity)
      this.amplitudes.set(density, found = {quantity, y: density.map((value, k) => amplitude(value, x[k] ?? 0, enbw_hz, quantity))});
    return found.y;
  }

  table(): Table {
    return curvesTable("frequency_hz", this.figure.shown(), this.drawn === "density" ? "(m/s2)^2/Hz" : `m/s2 ${this.drawn}`);
  }

  canvases(): HTMLCanvasElement[] {
    return [this.figure.canvas() ?? []].flat();
  }

  captions(): string[] {
    return [this.figure.text(), this.caption.textContent ?? ""];
  }

  keepReference(): void {
    this.reference = this.now;
  }

  dropReference(): void {
    this.reference = [];
  }
}
