// What has happened that lights a lamp: kept here, for counters begin anew with each start of a node, and what they
// said before must not go out unseen.
import {isFresh, type Car} from "./car";
import {AlarmCause, ClockState, type ClockFit, type Heartbeat, type Level} from "./wire";

/** Clocks of two nodes may be apart by so much: as common/bus/alarm.hpp. */
export const kWantedSync_s = 50e-6;

export type LampName = "LOSS" | "SYNC" | "OVERLOAD" | "ENCODER";

export interface Event {
  readonly lamp: LampName;
  readonly cause: AlarmCause;
  /** Node, or node.channel. */
  readonly where: string;
  /** How much of it by now. */
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

/** The others last. */
const kCounted = new Set([AlarmCause.SamplesLost, AlarmCause.ClockBroken, AlarmCause.FaultyTurns]);

const sum = (counts: readonly number[]) => counts.reduce((a, b) => a + b, 0);
export const lost = (beat: Heartbeat) => beat.scans_missing + beat.scans_refused;
export const faults = (beat: Heartbeat) => sum(beat.encoder_faults);

export class EventLog {
  private readonly events: Event[] = [];
  /** Counters as they were heard last, by lamp, node and epoch. */
  private readonly counters = new Map<string, number>();
  /** Epochs of nodes whose clocks have been known as well as is wanted: what is worse from then on is an event. */
  private readonly wellKnown = new Map<number, number>();
  private readonly totals = new Map<LampName, number>();

  /** Takes what is known now. */
  take(car: Car, nowMs: number): void {
    for (const {message: beat} of car.heartbeats.values()) {
      this.rise("LOSS", AlarmCause.SamplesLost, `node ${beat.node}`, beat.epoch, lost(beat), nowMs);
      this.rise("ENCODER", AlarmCause.FaultyTurns, `node ${beat.node}`, beat.epoch, faults(beat), nowMs);
    }
    for (const heard of car.clocks.values()) {
      const {message: fit} = heard;
      this.rise("SYNC", AlarmCause.ClockBroken, `node ${fit.node}`, fit.epoch, fit.breaks, nowMs);
      if (isFresh(heard, nowMs)) this.clock(fit, nowMs);
    }
  }

  private clock(fit: ClockFit, nowMs: number): void {
    const where = `node ${fit.node}`;
    if (fit.state === ClockState.Holdover) this.add("SYNC", AlarmCause.ClockUnheard, where, 1, nowMs);
    if (fit.state !== ClockState.Locked) return;
    if (fit.uncertainty_s <= kWantedSync_s) this.wellKnown.set(fit.node, fit.epoch);
    else if (this.wellKnown.get(fit.node) === fit.epoch) this.add("SYNC", AlarmCause.ClockPoor, where, 1, nowMs);
  }

  /** Takes each level: the next may be without what this one says. */
  overload(level: Level, atMs: number): void {
    for (let channel = 0; channel < level.peak.length; ++channel)
      if ((level.overload >> channel) & 1) this.add("OVERLOAD", AlarmCause.Overload, `channel ${level.node}.${channel + 1}`, 1, atMs);
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

  private rise(lamp: LampName, cause: AlarmCause, where: string, epoch: number, count: number, nowMs: number): void {
    const name = `${lamp} ${where} ${epoch}`;
    const before = this.counters.get(name) ?? 0;
    if (count <= before) return;  // late ones, too
    this.counters.set(name, count);
    if (this.counters.size > 4 * kMostEvents) {
      const [oldest] = this.counters.keys();
      if (oldest !== undefined && oldest !== name) this.counters.delete(oldest);
    }
    this.totals.set(lamp, this.total(lamp) + count - before);
    this.add(lamp, cause, where, count - before, nowMs);
  }

  private add(lamp: LampName, cause: AlarmCause, where: string, count: number, atMs: number): void {
    const same = this.events.find((event) => event.lamp === lamp && event.cause === cause && event.where === where && !event.seen &&
      atMs - event.lastMs <= kTogetherMs);
    if (same) {
      if (kCounted.has(cause)) same.count += count;
      same.lastMs = Math.max(same.lastMs, atMs);
      return;
    }
    this.events.push({lamp, cause, where, count, firstMs: atMs, lastMs: atMs, seen: false});
    const of = this.events.filter((event) => event.lamp === lamp);
    const oldest = of.find(({seen}) => seen) ?? of[0];
    if (of.length > kMostEvents && oldest) this.events.splice(this.events.indexOf(oldest), 1);
  }
}
