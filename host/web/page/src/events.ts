// What has happened that lights a lamp: kept here, for counters begin anew with each start of a node, and what they
// said before must not go out unseen.
import type {Car} from "./car";
import type {Heartbeat, Level} from "./wire";

export type LampName = "LOSS" | "SYNC" | "OVERLOAD" | "ENCODER";

export interface Event {
  readonly lamp: LampName;
  /** Node, or node.channel. */
  readonly where: string;
  /** What and how much of it by now. */
  count: number;
  readonly firstMs: number;
  /** Of this page's clock. */
  lastMs: number;
  seen: boolean;
}

/** Of each lamp; older ones are forgotten once they have been seen. */
const kMostEvents = 50;
/** What goes on is one event, not one a second. */
const kTogetherMs = 10_000;

const sum = (counts: readonly number[]) => counts.reduce((a, b) => a + b, 0);
export const lost = (beat: Heartbeat) => beat.scans_missing + beat.scans_refused;
export const faults = (beat: Heartbeat) => sum(beat.encoder_faults);

export class EventLog {
  private readonly events: Event[] = [];
  /** Counters as they were heard last, by lamp, node and epoch. */
  private readonly counters = new Map<string, number>();
  private readonly totals = new Map<LampName, number>();

  /** Takes what is known now. */
  take(car: Car, nowMs: number): void {
    for (const {message: beat} of car.heartbeats.values()) {
      this.rise("LOSS", `node ${beat.node}`, beat.epoch, lost(beat), nowMs);
      this.rise("ENCODER", `node ${beat.node}`, beat.epoch, faults(beat), nowMs);
    }
    for (const {message: fit} of car.clocks.values()) this.rise("SYNC", `node ${fit.node}`, fit.epoch, fit.breaks, nowMs);
  }

  /** Takes each level: the next may be without what this one says. */
  overload(level: Level, atMs: number): void {
    for (let channel = 0; channel < level.peak.length; ++channel)
      if ((level.overload >> channel) & 1) this.add("OVERLOAD", `channel ${level.node}.${channel + 1}`, 1, atMs);
  }

  /** The newest first. */
  of(lamp: LampName): Event[] {
    return this.events.filter((event) => event.lamp === lamp).sort((a, b) => b.lastMs - a.lastMs);
  }

  /** Those that nobody has seen yet. */
  unseen(lamp: LampName): Event[] {
    return this.of(lamp).filter(({seen}) => !seen);
  }

  /** Over all starts of all nodes that this page has heard of. */
  total(lamp: LampName): number {
    return this.totals.get(lamp) ?? 0;
  }

  acknowledge(): void {
    for (const event of this.events) event.seen = true;
  }

  private rise(lamp: LampName, where: string, epoch: number, count: number, nowMs: number): void {
    const name = `${lamp} ${where} ${epoch}`;
    const before = this.counters.get(name) ?? 0;
    if (count <= before) return;  // late ones, too
    this.counters.set(name, count);
    if (this.counters.size > 4 * kMostEvents) {
      const [oldest] = this.counters.keys();
      if (oldest !== undefined && oldest !== name) this.counters.delete(oldest);
    }
    this.totals.set(lamp, this.total(lamp) + count - before);
    this.add(lamp, where, count - before, nowMs);
  }

  private add(lamp: LampName, where: string, count: number, atMs: number): void {
    const same = this.events.find((event) => event.lamp === lamp && event.where === where && !event.seen &&
      atMs - event.lastMs <= kTogetherMs);
    if (same) {
      if (lamp !== "OVERLOAD") same.count += count;
      same.lastMs = Math.max(same.lastMs, atMs);
      return;
    }
    this.events.push({lamp, where, count, firstMs: atMs, lastMs: atMs, seen: false});
    const of = this.events.filter((event) => event.lamp === lamp);
    const oldest = of.find(({seen}) => seen) ?? of[0];
    if (of.length > kMostEvents && oldest) this.events.splice(this.events.indexOf(oldest), 1);
  }
}
