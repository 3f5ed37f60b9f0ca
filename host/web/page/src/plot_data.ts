// The analyser's data for this page's plots.  Memory is bounded by the limits of a View.
import {channelKey, type ChannelId} from "./channels";
import {decode, type Arrival} from "./decode";
import {EnvelopeRing} from "./plot_ring";
import {
  kEnvelope, kOrders, kSpectrum, kTransfer, kWaterfall, type Orders, type Spectrum, type Transfer, type Waterfall,
} from "./wire";

/** A part of something, as it came. */
interface Part {
  readonly part: number;
  readonly parts: number;
  readonly time_ns: number;
}

/** Parts of one kind that belong together. */
export class Assembly<T extends Part> {
  private parts: (T | undefined)[] = [];
  /** All parts of one time. */
  whole: readonly T[] = [];

  take(part: T): void {
    if (this.parts.length !== part.parts || this.parts.some((other) => other && other.time_ns !== part.time_ns))
      this.parts = Array.from<T | undefined>({length: part.parts});
    this.parts[part.part] = part;
    if (this.parts.every((other): other is T => other !== undefined)) this.whole = this.parts as T[];
  }
}

/** One array of all parts, what counts of each. */
export function joined<T extends Part & {readonly bins: number}>(parts: readonly T[], of: (part: T) => readonly number[]): number[] {
  return parts.flatMap((part) => of(part).slice(0, part.bins));
}

/** Frequencies of all bins, Hz. */
export function frequencies(parts: readonly {readonly first_hz: number; readonly step_hz: number; readonly bins: number}[]): number[] {
  return parts.flatMap(({first_hz, step_hz, bins}) => Array.from({length: bins}, (_, k) => first_hz + k * step_hz));
}

export const pairKey = (input: ChannelId, output: ChannelId) => `${channelKey(input)}>${channelKey(output)}`;
export const waterfallKey = (wheel: number, channel: ChannelId) => `${wheel}:${channelKey(channel)}`;

/** 1 .. 2^52, so that no two pages meet. */
function anyNumber(): number {
  const [high = 0, low = 0] = crypto.getRandomValues(new Uint32Array(2));
  return 1 + high * 2 ** 20 + (low >>> 12);
}

const kMostClasses = 100;

export class PlotData {
  /** Calls itself this in what it asks: any number but 0 (view_t). */
  readonly viewer = anyNumber();
  readonly spectra = new Map<string, Assembly<Spectrum>>();
  readonly transferFunctions = new Map<string, Assembly<Transfer>>();
  readonly envelopes = new Map<string, EnvelopeRing>();
  /** By class of speed. */
  readonly waterfalls = new Map<string, Map<number, Waterfall>>();
  /** By "wheel.node". */
  readonly orders = new Map<string, Orders>();

  /** Only what is wanted is kept. */
  want(spectra: readonly string[], transferFunctions: readonly string[], envelopes: readonly string[], waterfalls: readonly string[]): void {
    keep(this.spectra, spectra, () => new Assembly<Spectrum>());
    keep(this.transferFunctions, transferFunctions, () => new Assembly<Transfer>());
    keep(this.envelopes, envelopes, () => new EnvelopeRing());
    keep(this.waterfalls, waterfalls, () => new Map<number, Waterfall>());
  }

  /** Another recording begins: what the one before has told says nothing of it. */
  begin(): void {
    this.orders.clear();
    for (const rows of this.waterfalls.values()) rows.clear();
  }

  /** False: it is of no type that is shown here. */
  take(arrival: Arrival): boolean {
    switch (arrival.fingerprint) {
      case kSpectrum.fingerprint: {
        const part = decode(kSpectrum, arrival);
        if (part.viewer === this.viewer) this.spectra.get(channelKey(part))?.take(part);
        return true;
      }
      case kTransfer.fingerprint: {
        const part = decode(kTransfer, arrival);
        const key = pairKey({node: part.input_node, channel: part.input_channel},
                            {node: part.output_node, channel: part.output_channel});
        if (part.viewer === this.viewer) this.transferFunctions.get(key)?.take(part);
        return true;
      }
      case kEnvelope.fingerprint: {
        const envelope = decode(kEnvelope, arrival);
        this.envelopes.get(channelKey(envelope))?.take(envelope);
        return true;
      }
      case kWaterfall.fingerprint: {
        const row = decode(kWaterfall, arrival);
        const rows = this.waterfalls.get(waterfallKey(row.wheel, row));
        if (rows && row.speed_class < kMostClasses) rows.set(row.lines > 0 ? row.speed_class : -1, row);
        return true;
      }
      case kOrders.fingerprint: {
        const report = decode(kOrders, arrival);
        if (this.orders.size < 1024) this.orders.set(`${report.wheel}.${report.node}`, report);
        return true;
      }
      default: return false;
    }
  }

  /** Numbers that are held: it must not grow with time. */
  size(): number {
    let size = 0;
    for (const {whole} of this.spectra.values()) size += 2 * joined(whole, ({density}) => density).length;
    for (const {whole} of this.transferFunctions.values()) size += 2 * 6 * joined(whole, ({input}) => input).length;
    for (const rows of this.waterfalls.values()) size += rows.size * 272;
    return size + this.envelopes.size * 24_000 + this.orders.size * 120;
  }
}

function keep<T>(map: Map<string, T>, keys: readonly string[], make: () => T): void {
  for (const key of map.keys()) if (!keys.includes(key)) map.delete(key);
  for (const key of keys) if (!map.has(key)) map.set(key, make());
}
