// Channels over time: the least and greatest of a few milliseconds each.
import {accelerations, carriers, channelKey, channelName} from "./channels";
import type {Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import type {Plot, Scene, Table} from "./plot";
import type {Wish} from "./plot_ask";
import {Choice, ChannelsChoice} from "./plot_choice";
import {Figure, kColours, type Curve} from "./plot_figure";
import {curvesTable} from "./plot_save";
import {ClockState} from "./wire";

const kSpans = {"2": "2 s", "10": "10 s", "30": "30 s", "60": "60 s"} as const;
/** More than a screen has columns nobody sees. */
const kMostColumns = 1000;

/** Host clock of an instant of a node's, ns; nothing as long as the clocks are not known. */
export function hostNs(car: Car, node: number, node_ns: number): number | undefined {
  const fit = car.clocks.get(node)?.message;
  return fit && fit.state !== ClockState.Acquire ? fit.host_ns + (node_ns - fit.node_ns) / (1 + fit.drift) : undefined;
}

export class TimePlot implements Plot {
  readonly id = "time";
  readonly title = "Time";
  readonly isSpectral = false;
  readonly element: HTMLElement;
  private readonly channels: ChannelsChoice;
  private readonly span: Choice<keyof typeof kSpans>;
  private readonly caption = el("p", {class: "caption", id: "time-caption"});
  private readonly figure = new Figure({
    id: "time-figure", label: "Time", xLabel: "Seconds before the newest sample", share: 1.1, bars: true,
    xText: (x) => `${x.toFixed(3)} s`});

  constructor(changed: () => void) {
    this.channels = new ChannelsChoice("time-channels", kColours, changed);
    this.span = new Choice<keyof typeof kSpans>("time-span", "Show", kSpans, "10", changed);
    this.element = el("section", {class: "plot"}, [
      el("div", {class: "choices"}, [this.channels.element, this.span.element]), this.figure.element, this.caption]);
  }

  wish(): Wish {
    return {envelopes: this.channels.value};
  }

  draw({car}: Scene): void {
    this.channels.offer(car, accelerations(car), carriers(car).slice(0, 2));
    const wanted = this.channels.value.map((id, k) => ({id, k, ring: car.plots.envelopes.get(channelKey(id))}));
    // The newest samples of nodes with clocks of their own are not of one instant.
    const newest = wanted.map(({id, ring}) => (ring && ring.end > 0 ? hostNs(car, id.node, ring.endNs) : undefined));
    const known = newest.every((ns) => ns !== undefined);
    const lead = known ? Math.max(...newest.map((ns) => ns ?? 0)) : 0;
    const curves: Curve[] = [];
    const span_s = Number(this.span.value);
    const bucket_s = wanted.find(({ring}) => ring && ring.end > 0)?.ring?.seconds ?? 0.005;
    const count = Math.round(span_s / bucket_s), merged = Math.max(1, Math.ceil(count / kMostColumns));
    const merged_s = merged * bucket_s, columns = Math.floor(count / merged);
    const x = Array.from({length: columns}, (_, at) => (at - columns + 0.5) * merged_s);
    wanted.forEach(({id, k, ring}, place) => {
      if (!ring || ring.end === 0) return;
      const {least, greatest, end} = ring.last(count, merged);
      // Moved to the columns of the others: by half a column at most.
      const behind_s = (known ? (lead - (newest[place] ?? lead)) * 1e-9 : 0) + (ring.end - end) * ring.seconds;
      const shift = Math.round(behind_s / merged_s);
      const placed = (y: readonly (number | null)[]) => x.map((_, at) => y[at + shift + y.length - columns] ?? null);
      const name = channelName(car, id);
      curves.push({name: `${name} least`, colour: k, x, y: placed(least)},
                  {name: `${name} greatest`, colour: k, x, y: placed(greatest), band: true});
    });
    this.figure.show(curves, "Acceleration, m/s²", [], [-span_s, 0]);
    const none = wanted.length > 0 && curves.length === 0;
    setText(this.caption, none ? "No samples yet: the analyser has not answered." :
      `Least and greatest sample of each ${(1000 * merged_s).toFixed(0)} ms; where a sample is missing there is a hole.`);
    // For a test of a sample's age when it is shown.
    setAttributes(this.element, {"data-newest-host-ns": known && curves.length > 0 ? String(Math.round(lead)) : ""});
  }

  table(): Table {
    return curvesTable("time_s", this.figure.shown(), "m/s2");
  }

  canvases(): HTMLCanvasElement[] {
    return [this.figure.canvas() ?? []].flat();
  }

  captions(): string[] {
    return [this.figure.text(), this.caption.textContent ?? ""];
  }
}
