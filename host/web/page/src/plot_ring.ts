// A ring buffer of the least and greatest values of a channel's last seconds, in memory that never grows.
import type {Envelope} from "./wire";

/** Buckets of about 5 ms: one minute. */
export const kRingBuckets = 12_000;

export class EnvelopeRing {
  private readonly least = new Float32Array(kRingBuckets).fill(Number.NaN);
  private readonly greatest = new Float32Array(kRingBuckets).fill(Number.NaN);
  private epoch = -1;
  /** One behind the newest bucket. */
  end = 0;
  /** Of a bucket. */
  seconds = 0.005;
  /** Node clock at the end of the newest bucket. */
  endNs = 0;

  /** What was missed is a hole; what comes twice is the same. */
  take(message: Envelope): void {
    if (message.epoch !== this.epoch || message.first + message.buckets < this.end - kRingBuckets) this.begin(message);
    for (let number = Math.max(this.end, message.first - kRingBuckets); number < message.first; ++number) this.put(number, NaN, NaN);
    for (let k = 0; k < message.buckets; ++k)
      this.put(message.first + k, message.least[k] ?? NaN, message.greatest[k] ?? NaN);
    this.end = Math.max(this.end, message.first + message.buckets);
    this.seconds = message.scans * message.period_ps * 1e-12;
    this.endNs = message.time_ns + message.buckets * this.seconds * 1e9;
  }

  private begin(message: Envelope): void {
    this.least.fill(Number.NaN);
    this.greatest.fill(Number.NaN);
    this.epoch = message.epoch;
    this.end = message.first;
  }

  private put(number: number, least: number, greatest: number): void {
    this.least[number % kRingBuckets] = least;
    this.greatest[number % kRingBuckets] = greatest;
  }

  /** The last `count` buckets, `merged` of them as one; null where nothing came.  Groups begin at multiples of `merged`,
      or what is old would flicker. */
  last(count: number, merged: number): {readonly least: (number | null)[]; readonly greatest: (number | null)[]; readonly end: number} {
    const end = Math.floor(this.end / merged);
    const groups = Math.floor(Math.min(count, kRingBuckets - merged) / merged);
    const least: (number | null)[] = [], greatest: (number | null)[] = [];
    for (let group = end - groups; group < end; ++group) {
      let low = Infinity, high = -Infinity, whole = group >= 0;
      for (let number = group * merged; whole && number < (group + 1) * merged; ++number) {
        const value = this.least[number % kRingBuckets] ?? NaN;
        if (Number.isNaN(value)) whole = false;
        low = Math.min(low, value);
        high = Math.max(high, this.greatest[number % kRingBuckets] ?? NaN);
      }
      least.push(whole ? low : null);
      greatest.push(whole ? high : null);
    }
    return {least, greatest, end: end * merged};
  }
}
