// Plots: one at a time, chosen by buttons; frozen, compared, saved.
import {isBusy, isFresh, type Car} from "./car";
import {channelKey} from "./channels";
import {el, setAttributes, setText} from "./dom";
import type {Key} from "./keys";
import type {Plot} from "./plot";
import {ask, viewOf, type Spectral} from "./plot_ask";
import {Choice} from "./plot_choice";
import {pairKey, waterfallKey} from "./plot_data";
import {PolarPlot} from "./plot_polar";
import {csv, picture, save} from "./plot_save";
import {kWindowNames, SpectrumPlot} from "./plot_spectrum";
import {SpeedPlot} from "./plot_speed";
import {TimePlot} from "./plot_time";
import {TransferFunctionPlot} from "./plot_transfer_function";
import {WaterfallPlot} from "./plot_waterfall";
import type {View} from "./view";
import type {View as Question} from "./wire";

/** The analyser forgets who says nothing for three seconds. */
const kAskMs = 1000;
const kKept = "plot";

const kBlocks = [1024, 2048, 4096, 8192, 16_384, 32_768, 65_536];

/** Blocks with the time that they take, of which a person judges how long he waits, at the rate of the nodes, NaN while nobody has told it. */
function blocks(rate_hz: number): Record<string, string> {
  return Object.fromEntries(kBlocks.map((size) =>
    [size, `${size} samples${rate_hz > 0 ? `, ${(size / rate_hz).toFixed(1)} s` : ""}`]));
}
const kAverages = {"4": "exponential, 4 blocks", "20": "exponential, 20 blocks", "100": "exponential, 100 blocks", "0": "linear",
                   "hold": "hold peaks"} as const;

/** How spectra are made, as a person chose it. */
class SpectralChoices {
  readonly element: HTMLElement;
  private readonly window: Choice<string>;
  private readonly block: Choice<string>;
  private readonly overlap: Choice<string>;
  private readonly average: Choice<keyof typeof kAverages>;
  private readonly highest: Choice<string>;

  constructor(heard: () => void) {
    this.window = new Choice<string>("plot-window", "Window", Object.fromEntries(kWindowNames.map((name, k) => [k, `${name} window`])), "1", heard);
    this.block = new Choice<string>("plot-block", "Block", blocks(NaN), "4096", heard);
    this.overlap = new Choice<string>("plot-overlap", "Overlap", {"0": "0 % overlap", "0.5": "50 % overlap", "0.75": "75 % overlap"}, "0.5", heard);
    this.average = new Choice<keyof typeof kAverages>("plot-average", "Average", kAverages, "20", heard);
    this.highest = new Choice<string>("plot-highest", "Range", {"50": "up to 50 Hz", "100": "up to 100 Hz", "250": "up to 250 Hz", "1000": "up to 1000 Hz"}, "100", heard);
    // The choices stand below each plot.
    this.element = el("details", {id: "plot-spectral"}, [
      el("summary", {}, ["Analysis"]),
      el("div", {class: "choices"}, [this.window, this.block, this.overlap, this.average, this.highest].map(({element}) => element))]);
  }

  /** All nodes of a car have one rate. */
  draw(car: Car): void {
    const [setup] = car.setups.values();
    if (setup) this.block.offer(blocks(setup.message.rate_hz));
  }

  get value(): Spectral {
    const average = this.average.value;
    return {segment: Number(this.block.value), window: Number(this.window.value), memory: average === "hold" ? 0 : Number(average),
            holdPeaks: average === "hold", overlap: Number(this.overlap.value), highestHz: Number(this.highest.value)};
  }
}

/** Before the start nodes send a preview, which tells levels only. */
function waitsForStart(car: Car, nowMs: number): string {
  const recorders = car.livingRecorders(nowMs);
  return recorders.length > 0 && !recorders.some(isBusy) ? "Nothing is recorded: plots begin with the recording." : "";
}

export class PlotView implements View {
  readonly id = "plots";
  readonly title = "Plots";
  readonly key = "P";
  readonly does = "plots";
  readonly keys: readonly Key[];
  readonly element: HTMLElement;
  private readonly plots: readonly Plot[];
  private readonly buttons = new Map<string, HTMLButtonElement>();
  private readonly spectral: SpectralChoices;
  private readonly freezeButton: HTMLButtonElement;
  private readonly compareButton: HTMLButtonElement;
  private readonly trouble = el("p", {class: "trouble", role: "status"});
  private now: Plot;
  private frozen = false;
  /** Plots that have a reference. */
  private readonly compared = new Set<Plot>();
  private timer: number | undefined;
  private asked = "";
  private refusal = "";
  private next: Question | undefined;
  private isAsking = false;

  constructor(private readonly car: Car) {
    const changed = () => {
      this.unfreeze();
      this.ask();
    };
    this.spectral = new SpectralChoices(changed);
    const spectrum = new SpectrumPlot(changed);
    this.plots = [spectrum, new TransferFunctionPlot(changed), new TimePlot(changed), new WaterfallPlot(changed), new PolarPlot(changed), new SpeedPlot()];
    this.now = this.plots.find(({id}) => id === sessionStorage.getItem(kKept)) ?? spectrum;
    const button = (id: string, text: string, run: () => void, pressed = true) => {
      const made = el("button", {type: "button", id, ...(pressed ? {"aria-pressed": "false"} : {})}, [text]);
      made.onclick = run;
      return made;
    };
    for (const plot of this.plots) this.buttons.set(plot.id, button(`plot-${plot.id}`, plot.title, () => this.choose(plot)));
    this.freezeButton = button("plot-freeze", "Freeze (F)", () => this.freeze());
    this.compareButton = button("plot-compare", "Compare (C)", () => this.compare());
    this.keys = [
      {key: "F", does: "freeze the plot, and go on", run: () => this.freeze()},
      {key: "C", does: "keep what is plotted as a reference, and drop it", run: () => this.compare()},
      {key: ",", does: "plot before", run: () => this.step(-1)},
      {key: ".", does: "next plot", run: () => this.step(1)},
    ];
    this.element = el("section", {class: "plots"}, [
      el("div", {class: "plot-bar"}, [
        el("div", {class: "plot-kinds", role: "group", "aria-label": "Which plot"}, [...this.buttons.values()]),
        this.spectral.element,
        el("div", {class: "plot-actions", role: "group", "aria-label": "With this plot"}, [
          this.freezeButton, this.compareButton,
          button("plot-picture", "Picture", () => this.savePicture(), false), button("plot-csv", "CSV", () => this.saveTable(), false)])]),
      this.trouble, ...this.plots.map(({element}) => element)]);
  }

  seen(is: boolean): void {
    if (this.timer !== undefined) clearInterval(this.timer);
    this.timer = is ? setInterval(() => this.ask(), kAskMs) : undefined;
    if (is) this.choose(this.now);
    else this.car.plots.want([], [], [], []);
  }

  draw(nowMs: number): void {
    // Levels come ten times a second, whatever else is asked for.
    const isOld = ![...this.car.levels.values()].some((heard) => isFresh(heard, nowMs));
    setAttributes(this.element, {"data-frozen": String(this.frozen), "data-old": String(isOld)});
    setText(this.trouble, isOld ? "OLD: no analyser is heard." : this.refusal || waitsForStart(this.car, nowMs));
    if (this.frozen) return;
    this.spectral.draw(this.car);
    this.now.draw({car: this.car, spectral: this.spectral.value, nowMs});
    // The channels, and so the data to ask for, may be known only now.
    if (this.timer !== undefined && JSON.stringify(this.now.wish()) !== this.asked) this.ask();
  }

  private choose(plot: Plot): void {
    this.now = plot;
    sessionStorage.setItem(kKept, plot.id);
    this.unfreeze();
    for (const other of this.plots) {
      other.element.hidden = other !== plot;
      const button = this.buttons.get(other.id);
      if (button) setAttributes(button, {"aria-pressed": String(other === plot)});
    }
    this.spectral.element.hidden = !plot.isSpectral;
    this.compareButton.hidden = !plot.keepReference;
    this.showCompared();
    this.draw(performance.now());
    this.ask();
  }

  private step(by: number): void {
    const next = this.plots[(this.plots.indexOf(this.now) + by + this.plots.length) % this.plots.length];
    if (next) this.choose(next);
  }

  private ask(): void {
    if (this.timer === undefined) return;
    const wish = this.now.wish();
    this.asked = JSON.stringify(wish);
    const {plots} = this.car;
    plots.want((wish.spectra ?? []).map(channelKey), (wish.pairs ?? []).map(([input, output]) => pairKey(input, output)),
               (wish.envelopes ?? []).map(channelKey), (wish.waterfalls ?? []).map(({wheel, channel}) => waterfallKey(wheel, channel)));
    this.next = viewOf(plots.viewer, this.spectral.value, wish);
    if (!this.isAsking) void this.say();
  }

  /** One question at a time, always the newest. */
  private async say(): Promise<void> {
    this.isAsking = true;
    while (this.next) {
      const view = this.next;
      this.next = undefined;
      this.refusal = await ask(view);
    }
    this.isAsking = false;
  }

  private freeze(): void {
    this.frozen = !this.frozen;
    setAttributes(this.freezeButton, {"aria-pressed": String(this.frozen)});
    setText(this.freezeButton, this.frozen ? "FROZEN – go on (F)" : "Freeze (F)");
    this.draw(performance.now());
  }

  private unfreeze(): void {
    if (this.frozen) this.freeze();
  }

  private compare(): void {
    const {now} = this;
    if (!now.keepReference) return;
    if (this.compared.delete(now)) now.dropReference?.();
    else {
      now.keepReference();
      this.compared.add(now);
    }
    this.showCompared();
    this.draw(performance.now());
  }

  private showCompared(): void {
    const is = this.compared.has(this.now);
    setAttributes(this.compareButton, {"aria-pressed": String(is)});
    setText(this.compareButton, is ? "Drop reference (C)" : "Compare (C)");
  }

  private name(ending: string): string {
    return `roadbalance-${this.now.id}-${new Date().toISOString().slice(0, 19).replaceAll(":", "-")}.${ending}`;
  }

  private savePicture(): void {
    const name = this.name("png");
    picture(this.now.canvases(), [this.now.title, ...this.now.captions()]).toBlob((blob) => blob && save(blob, name), "image/png");
  }

  private saveTable(): void {
    save(new Blob([csv(this.now.table())], {type: "text/csv"}), this.name("csv"));
  }
}
