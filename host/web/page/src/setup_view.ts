// The wiring as described, whether tap tests confirm it, and whether all is ready.
import type {Car} from "./car";
import {faultOf, isClipped} from "./channel_faults";
import {placeAndName} from "./channels";
import {alsoFelt, isRight, Taps, type Felt, type Place} from "./taps";
import {directionWord, knockWord} from "./directions";
import {el, setAttributes, setRows, setText, svg, table, type Cell} from "./dom";
import {preflight, type Ready} from "./preflight";
import {kCross, kLine, kTick} from "./signs";
import {untilZero} from "./text";
import type {View} from "./view";
import {kWheelNames} from "./wheel_place";
import {ChannelRole, EncoderTrait, type Setup} from "./wire";

/** Tables need not follow each frame. */
const kRedrawMs = 500;

const kShapes: Readonly<Record<Ready, string>> = {
  yes: kTick,
  unknown: kLine,
  no: kCross,
};
const kReadyWords: Readonly<Record<Ready, string>> = {yes: "OK", unknown: "not known", no: "TO DO"};

const at = (mount: number) => (mount < 0 ? "body" : kWheelNames[mount] ?? "?");
const number = (value: number, digits: number) =>
  (value !== 0 && Math.abs(value) < 1e-3 ? value.toExponential(digits - 1) : Number(value.toPrecision(digits)).toString());

class CheckLine {
  private readonly shape = svg("path");
  private readonly word = el("span", {class: "word"});
  private readonly name = el("strong");
  private readonly says = el("span");
  readonly element = el("li", {}, [
    svg("svg", {viewBox: "0 0 16 16", "aria-hidden": "true"}, [this.shape]), this.word, this.name, this.says]);

  draw(name: string, ready: Ready, says: string): void {
    setAttributes(this.element, {"data-ready": ready});
    setAttributes(this.shape, {d: kShapes[ready]});
    setText(this.word, kReadyWords[ready]);
    setText(this.name, name);
    setText(this.says, says);
  }
}

export class SetupView implements View {
  readonly id = "setup";
  readonly title = "Set-up";
  readonly key = "S";
  readonly does = "set-up: nodes, channels, encoders, tap test, pre-flight check";
  readonly element: HTMLElement;
  private readonly taps = new Taps();
  private readonly verdict = el("small");
  private readonly checks = el("ul", {class: "checks"});
  private readonly lines: CheckLine[] = [];
  private readonly knock = el("p", {id: "knock", role: "status"});
  private readonly tapped = el("select", {id: "tap-channel"});
  private offered = "";
  private readonly channels = el("tbody");
  private readonly encoders = el("tbody");
  private readonly nodes = el("tbody");
  private drawnMs = -Infinity;

  constructor(private readonly car: Car) {
    this.tapped.onchange = () => {
      const [node, channel] = this.tapped.value.split(" ").map(Number);
      this.taps.meant = node === undefined || channel === undefined ? undefined : {node, channel};
      this.taps.last = undefined;
      this.tapped.blur();
      this.seen();
    };
    this.element = el("section", {class: "setup"}, [
      el("h2", {}, ["Ready to record? ", this.verdict]), this.checks,
      el("h2", {}, ["Tap test"]),
      el("p", {}, ["With the car at rest choose a sensor and knock lightly on it, the way the table says: here shows which channel " +
                   "rings, and whether its sign is that of vehicle.toml. Do it on both sides: a sensor fitted the " +
                   "same way round on the right as on the left may point the other way."]),
      el("p", {}, [el("label", {for: "tap-channel"}, ["I knock on: "]), this.tapped]),
      this.knock,
      el("h2", {}, ["Channels"]),
      table("Channels", ["channel", "sensor", "on", "positive", "knock", "range m/s²", "m/s² per count", "offset counts",
                         "delay µs", "now m/s² rms", "proven"], this.channels),
      el("h2", {}, ["Encoders"]),
      table("Encoders", ["wheel", "node line", "teeth", "kind", "mark at", "faulty turns", "turns"], this.encoders),
      el("h2", {}, ["Nodes and filter"]),
      table("Nodes", ["node", "name", "vehicle file", "scans a second", "anti-aliasing filter"], this.nodes),
      el("h2", {}, ["Calibration"]),
      el("p", {}, ["Zero marks, zeros and scales of channels are set in Equipment (E). These want your hands or a recording made for them, so they are commands on the computer that has vehicle.toml:"]),
      el("dl", {class: "commands"}, [
        el("dt", {}, ["Where a zero mark fires, by a trial weight: 50 g at the valve between two drives"]),
        el("dd", {}, [el("code", {}, ["rb datum --wheel front_left --before DRIVE1 --after DRIVE2 --grams 50 --at 0 --vehicle vehicle.toml"])]),
        el("dt", {}, ["Gain and delay of channels against each other: one voltage on all inputs, recorded"]),
        el("dd", {}, [el("code", {}, ["rb calibrate channels RECORDING --vehicle vehicle.toml"])]),
        el("dt", {}, ["The same with sensors side by side on one shaking body"]),
        el("dd", {}, [el("code", {}, ["rb calibrate channels RECORDING --motion --vehicle vehicle.toml"])])])]);
  }

  seen(): void {
    this.drawnMs = -Infinity;
  }

  draw(nowMs: number): void {
    this.taps.take(this.car);
    if (nowMs - this.drawnMs < kRedrawMs) return;
    this.drawnMs = nowMs;
    this.drawChecks(nowMs);
    setText(this.knock, whatWasFelt(this.taps));
    const setups = [...this.car.setups.values()].map(({message}) => message).sort((a, b) => a.node - b.node);
    this.offer(setups);
    setRows(this.channels, setups.flatMap((setup) => Array.from({length: setup.channels}, (_, k) => this.channelRow(setup, k))));
    setRows(this.encoders, setups.flatMap((setup) => setup.wheel.flatMap((wheel, line) => (wheel < 0 ? [] : [this.encoderRow(setup, line)]))));
    setRows(this.nodes, setups.map((setup) => [
      {text: String(setup.node)}, {text: untilZero(setup.name)},
      {text: `${untilZero(setup.vehicle)} (${(setup.vehicle_crc32c >>> 0).toString(16).padStart(8, "0")})`},
      {text: number(setup.rate_hz, 6)}, {text: `Butterworth, order ${setup.filter_order}, ${number(setup.filter_cutoff_hz, 4)} Hz`}]));
  }

  private drawChecks(nowMs: number): void {
    const checks = preflight(this.car, this.taps, nowMs);
    while (this.lines.length > checks.length) this.lines.pop()?.element.remove();
    while (this.lines.length < checks.length) {
      const line = new CheckLine();
      this.lines.push(line);
      this.checks.append(line.element);
    }
    checks.forEach(({name, ready, says}, k) => this.lines[k]?.draw(name, ready, says));
    const open = checks.filter(({ready}) => ready === "no").length;
    const unknown = checks.filter(({ready}) => ready === "unknown").length;
    setText(this.verdict, open > 0 ? `${open} to do` : unknown > 0 ? `${unknown} not known yet` : "everything is");
  }

  /** Channels that can be knocked on. */
  private offer(setups: readonly Setup[]): void {
    const all = setups.flatMap((setup) => Array.from({length: setup.channels}, (_, channel) => ({setup, channel})))
      .filter(({setup, channel}) => setup.role[channel] !== ChannelRole.Unused);
    const offered = all.map(({setup, channel}) => placeAndName(setup, channel)).join();
    if (offered === this.offered) return;
    this.offered = offered;
    this.taps.meant = undefined;
    this.tapped.replaceChildren(el("option", {value: ""}, ["choose a sensor"]), ...all.map((place) =>
      el("option", {value: `${place.setup.node} ${place.channel}`}, [placeAndName(place.setup, place.channel)])));
  }

  private channelRow(setup: Setup, k: number): Cell[] {
    const level = this.car.levels.get(setup.node)?.message;
    const fault = level ? faultOf(level, k) : "";
    const over = !level ? "" : (level.overload >> k) & 1 ? "OVER" : isClipped(level, k) ? "CLIP" : "";
    const tap = this.taps.of(setup, k);
    const direction = setup.direction[k] ?? [];
    const unused = setup.role[k] === ChannelRole.Unused;
    return [
      {text: `${setup.node}.${k + 1}`}, {text: untilZero(setup.channel_name[k] ?? [])},
      {text: unused ? "not used" : setup.role[k] === ChannelRole.Road ? `road under ${at(setup.mount[k] ?? -1)}` : at(setup.mount[k] ?? -1)},
      {text: directionWord(direction)}, {text: knockWord(direction)},
      {text: number(setup.range_m_s2[k] ?? 0, 4)}, {text: number(setup.scale_m_s2_per_count[k] ?? 0, 5)},
      {text: number(setup.offset_counts[k] ?? 0, 6)}, {text: number(1e6 * (setup.delay_s[k] ?? 0), 4)},
      {text: !level ? "–" : over || fault || (level.rms[k] ?? 0).toPrecision(2), tone: over ? "bad" : fault ? "warn" : ""},
      {text: tap === "right" ? "✓ by knock" : tap === "wrong" ? "✗ WRONG SIGN" : "not yet", tone: tap === "right" ? "good" : tap === "wrong" ? "bad" : "quiet"}];
  }

  private encoderRow(setup: Setup, line: number): Cell[] {
    const traits = setup.encoder[line] ?? 0;
    const beat = this.car.heartbeats.get(setup.node)?.message;
    const faults = beat?.encoder_faults[line];
    const level = this.car.levels.get(setup.node)?.message;
    const kind = [traits & EncoderTrait.CountedOnBus ? "teeth counted on the bus" : "teeth on the line",
                  traits & EncoderTrait.ZeroMark ? "zero mark" : "NO ZERO MARK", ...(traits & EncoderTrait.Quadrature ? ["quadrature"] : [])];
    const degrees = (angle_rad: number, digits: number) => (angle_rad * 180 / Math.PI).toFixed(digits);
    const first = setup.wheel.findIndex((wheel) => wheel >= 0) === line;
    const turning = level && Number.isFinite(level.speed_m_s);
    return [
      {text: kWheelNames[setup.wheel[line] ?? -1] ?? "?"}, {text: `${setup.node} line ${line + 1}`},
      {text: String(setup.pulses_per_turn[line] ?? 0)}, {text: kind.join(", ")},
      {text: traits & EncoderTrait.ZeroMark ? `${degrees(setup.datum_rad[line] ?? 0, 1)}° ± ${degrees(setup.datum_sigma_rad[line] ?? 0, 1)}°` : "–"},
      {text: faults === undefined ? "–" : String(faults), tone: faults ? "bad" : ""},
      {text: !level ? "–" : first ? (turning ? "yes" : "no angle") : "–", tone: first && level && !turning ? "warn" : ""}];
  }
}

function whyNot({setup, knock, meant}: Felt): string {
  const others = alsoFelt(setup, knock).map((channel) => placeAndName(setup, channel));
  if (!meant) return "Proves nothing: choose first what you knock on.";
  if (!isAt(meant, setup.node, knock.channel))
    return "Proves nothing: it is not what was chosen. If that was knocked on, its cable is in another input than vehicle.toml says.";
  return `Proves nothing: nearly as much was felt by ${others.join(", ")}. Knock again, closer.`;
}
const isAt = (place: Place, node: number, channel: number) => place.node === node && place.channel === channel;

/** The last knock since a sensor was chosen. */
function whatWasFelt({last, meant}: Taps): string {
  if (!last) return meant ? "No knock was felt yet." : "No sensor is chosen.";
  const {setup, knock, proves} = last;
  const first = knock.first_m_s2[knock.channel] ?? 0;
  const way = knockWord(setup.direction[knock.channel] ?? []);
  return `Knock on ${placeAndName(setup, knock.channel)}: first swing ${first < 0 ? "−" : "+"}${Math.abs(first).toPrecision(2)} m/s². ` +
    (!proves ? whyNot(last) : isRight(setup, knock) ? `Right, if it came ${way}.` : `WRONG SIGN, if it came ${way}.`);
}
