// Transfer function, its phase, and coherence of a pair of channels on one axis of frequency.
import {accelerations, carriers, channelName} from "./channels";
import {el, setText} from "./dom";
import type {Plot, Scene, Table} from "./plot";
import type {Wish} from "./plot_ask";
import {Choice, ChannelChoice} from "./plot_choice";
import {pairKey} from "./plot_data";
import {Figure, figures, type Curve, type Marker} from "./plot_figure";
import {curvesTable} from "./plot_save";
import {kReasons, orderChoice, orderMarkers, spectralCaption} from "./plot_spectrum";
import {meanDelay_s, transferFunctionCurves, type Estimator, type TransferFunctionCurves} from "./transfer_function";
import {SpectralState, type Transfer} from "./wire";

const kEstimators: Readonly<Record<Estimator, string>> = {
  h1: "H1 (noise on the output)", h2: "H2 (noise on the input)", hv: "Hv (noise on both)"};
const kTogether = "transfer";
const xText = (x: number) => `${x.toFixed(2)} Hz`;

export class TransferFunctionPlot implements Plot {
  readonly id = "transfer";
  readonly title = "Transfer";
  readonly isSpectral = true;
  readonly element: HTMLElement;
  private readonly input: ChannelChoice;
  private readonly output: ChannelChoice;
  private readonly estimator: Choice<Estimator>;
  private readonly orders: Choice<string>;
  private readonly caption = el("p", {class: "caption", id: "transfer-caption"});
  // Three figures have three lines of readings: together they are somewhat lower than one.
  private readonly magnitude = new Figure({id: "transfer-magnitude", label: "Transfer function", xLabel: "", share: 0.365,
                                           logarithmic: true, together: kTogether, xText});
  private readonly phase = new Figure({id: "transfer-phase", label: "Phase", xLabel: "", share: 0.245, range: [-180, 180],
                                       splits: [-180, -90, 0, 90, 180], together: kTogether, xText});
  private readonly coherence = new Figure({id: "transfer-coherence", label: "Coherence", xLabel: "Frequency, Hz", share: 0.33,
                                           range: [0, 1], together: kTogether, xText});
  private reference: {readonly curves: TransferFunctionCurves; readonly name: string} | undefined;
  private now: {readonly curves: TransferFunctionCurves; readonly name: string} | undefined;
  /** Of what `now` was computed. */
  private from: readonly [readonly Transfer[], Estimator] | undefined;

  constructor(changed: () => void) {
    this.input = new ChannelChoice("transfer-input", "From", changed);
    this.output = new ChannelChoice("transfer-output", "to", changed);
    this.estimator = new Choice("transfer-estimator", "Estimate", kEstimators, "h1", changed);
    this.orders = orderChoice("transfer-orders", changed);
    this.element = el("section", {class: "plot"}, [
      el("div", {class: "choices"}, [this.input.element, this.output.element, this.estimator.element, this.orders.element]),
      this.magnitude.element, this.phase.element, this.coherence.element,
      el("div", {class: "readings", id: "transfer-readings"}, [this.magnitude, this.phase, this.coherence].map(({reading}) => reading)),
      this.caption]);
  }

  wish(): Wish {
    const [input, output] = [this.input.value, this.output.value];
    return input && output ? {pairs: [[input, output]]} : {};
  }

  draw({car, spectral}: Scene): void {
    const all = accelerations(car), [first = all[0], second = all[1]] = carriers(car);
    this.input.offer(car, all, first);
    this.output.offer(car, all, second);
    const [input, output] = [this.input.value, this.output.value];
    const parts = input && output ? car.plots.transferFunctions.get(pairKey(input, output))?.whole ?? [] : [];
    const [part] = parts;
    if (!input || !output || !part || part.state !== SpectralState.Computed) {
      this.now = undefined;
      setText(this.caption, part ? kReasons[part.state as SpectralState] ?? "Not known." : "The analyser has not answered yet.");
    } else {
      const estimator = this.estimator.value;
      const isKnown = this.now && this.from?.[0] === parts && this.from[1] === estimator;
      this.from = [parts, estimator];
      this.now = {curves: isKnown && this.now ? this.now.curves : transferFunctionCurves(parts, estimator),
                  name: `${estimator.toUpperCase()} ${channelName(car, input)} → ${channelName(car, output)}`};
      const delay = meanDelay_s(parts);
      setText(this.caption, `${spectralCaption(spectral, part)}; worth ${figures(part.independent_averages)} independent blocks. ` +
        "The band holds the magnitude with 95 %; no phase where it holds 0. " +
        (delay === undefined ? "No coherence: no delay." : `Mean delay of the output ${(1000 * delay).toFixed(2)} ms.`));
    }
    this.show(this.orders.value === "" ? [] : orderMarkers(car, Number(this.orders.value)));
  }

  private show(markers: readonly Marker[]): void {
    const magnitude: Curve[] = [], phase: Curve[] = [], coherence: Curve[] = [];
    if (this.now) {
      const {curves, name} = this.now, x = curves.hz;
      magnitude.push({name, colour: 0, x, y: curves.magnitude}, {name: "95 % from", colour: 0, x, y: curves.least_drawn, silent: true, faint: true, mayLeave: true},
                     {name: "95 % to", colour: 0, x, y: curves.greatest, band: true, silent: true, faint: true});
      phase.push({name: "phase", colour: 0, x, y: curves.phase_deg});
      coherence.push({name: "coherence", colour: 0, x, y: curves.coherence},
                     {name: "by chance (95 %)", colour: 1, x, y: curves.by_chance, dashed: true});
    }
    if (this.reference) {
      const {curves, name} = this.reference, x = curves.hz;
      magnitude.push({name: `${name} (reference)`, colour: 2, x, y: curves.magnitude, dashed: true});
      phase.push({name: "reference", colour: 2, x, y: curves.phase_deg, dashed: true});
      coherence.push({name: "reference", colour: 2, x, y: curves.coherence, dashed: true});
    }
    this.magnitude.show(magnitude, "Magnitude", markers);
    this.phase.show(phase, "Phase, °", markers);
    this.coherence.show(coherence, "Coherence", markers);
  }

  table(): Table {
    if (!this.now) return {head: [], columns: []};
    const {curves, name} = this.now, x = curves.hz;
    const table = curvesTable("frequency_hz", [
      {name: `${name} magnitude`, colour: 0, x, y: curves.magnitude}, {name: "95 % from", colour: 0, x, y: curves.least},
      {name: "95 % to", colour: 0, x, y: curves.greatest}, {name: "phase_deg", colour: 0, x, y: curves.phase_deg},
      {name: "coherence", colour: 0, x, y: curves.coherence}, {name: "input (m/s2)^2/Hz", colour: 0, x, y: curves.input},
      {name: "output (m/s2)^2/Hz", colour: 0, x, y: curves.output}], "");
    return table;
  }

  canvases(): HTMLCanvasElement[] {
    return [this.magnitude, this.phase, this.coherence].flatMap((figure) => figure.canvas() ?? []);
  }

  captions(): string[] {
    return [[this.magnitude, this.phase, this.coherence].map((figure) => figure.text()).join(" "), this.caption.textContent ?? ""];
  }

  keepReference(): void {
    this.reference = this.now;
  }

  dropReference(): void {
    this.reference = undefined;
  }
}
