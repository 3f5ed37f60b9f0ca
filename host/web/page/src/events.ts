// Keeps the events that light a lamp: a node's counters begin anew with each start, and a lamp must not go out unseen.
import {isFresh, kSilenceMs, type Car, type Heard} from "./car";
import {isClipped} from "./channel_faults";
import {AlarmCause, ClockState, DeviceCounter, kClockPatience_s, kWantedSync_s, NodeState, TimeBase, type ClockFit, type Heartbeat, type Level} from "./wire";

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
/** Of nodes that have a device that is not there: the same judgement as AlarmWatch's. */
export const withoutDevice = (car: Car) =>
  [...car.heartbeats.values()].map(({message}) => message)
    .filter(({device_counts: counts}) => (counts[DeviceCounter.Gone] ?? 0) > (counts[DeviceCounter.Returned] ?? 0));
export const faults = (beat: Heartbeat) => sum(beat.encoder_faults);

/** It is recorded and has a clock of its own, which the recorder asks for its time. */
export const wantsClock = ({time_base, state, owner}: Heartbeat) =>
  time_base === TimeBase.Own && state === NodeState.Started && owner !== 0;

/** A clock that is asked: the same judgement as AlarmWatch's, which puts it into the record. */
interface AskedClock {
  readonly epoch: number;
  readonly sinceMs: number;
  /** Last, and locked. */
  heardMs: number;
  /** Of its node, any word. */
  nodeMs: number;
  /** What is worse from then on is an event at once. */
  wasWellKnown: boolean;
}

export class EventLog {
  private readonly events: Event[] = [];
  /** Counters as they were heard last, by lamp, node and epoch. */
  private readonly counters = new Map<string, number>();
  /** By node. */
  private readonly asked = new Map<number, AskedClock>();
  private readonly totals = new Map<LampName, number>();

  /** Takes what is known now. */
  take(car: Car, nowMs: number): void {
    for (const {message: beat} of car.heartbeats.values()) {
      this.rise("LOSS", AlarmCause.SamplesLost, `node ${beat.node}`, beat.epoch, lost(beat), nowMs);
      this.rise("ENCODER", AlarmCause.FaultyTurns, `node ${beat.node}`, beat.epoch, faults(beat), nowMs);
    }
    for (const heard of car.heartbeats.values()) this.ask(heard);
    for (const heard of car.clocks.values()) {
      const {message: fit} = heard;
      this.rise("SYNC", AlarmCause.ClockBroken, `node ${fit.node}`, fit.epoch, fit.breaks, nowMs);
      if (isFresh(heard, nowMs)) this.clock(heard, nowMs);
    }
    // The silence of a node is an event of its own.
    for (const [node, clock] of this.asked)
      if (nowMs - clock.nodeMs <= kSilenceMs && nowMs - clock.heardMs >= 1000 * kClockPatience_s)
        this.add("SYNC", AlarmCause.ClockUnheard, `node ${node}`, 1, nowMs);
  }

  /** It has been asked so long that it should be known. */
  isOverdue(node: number, nowMs: number): boolean {
    const clock = this.asked.get(node);
    return clock !== undefined && nowMs - clock.sinceMs >= 1000 * kClockPatience_s;
  }

  private ask({message: beat, atMs}: Heard<Heartbeat>): void {
    const known = this.asked.get(beat.node);
    if (!wantsClock(beat)) {
      this.asked.delete(beat.node);
    } else if (known?.epoch !== beat.epoch) {
      this.asked.set(beat.node, {epoch: beat.epoch, sinceMs: atMs, heardMs: atMs, nodeMs: atMs, wasWellKnown: false});
    } else {
      // While no message came from the node, or none to this page, the time does not count.
      if (atMs - known.nodeMs > kSilenceMs) known.heardMs = atMs;
      known.nodeMs = atMs;
    }
  }

  private clock({message: fit, atMs}: Heard<ClockFit>, nowMs: number): void {
    const where = `node ${fit.node}`;
    if (fit.state === ClockState.Holdover) this.add("SYNC", AlarmCause.ClockUnheard, where, 1, nowMs);
    const clock = this.asked.get(fit.node);
    if (fit.state !== ClockState.Locked || clock?.epoch !== fit.epoch) return;
    clock.heardMs = Math.max(clock.heardMs, atMs);
    if (fit.uncertainty_s <= kWantedSync_s) clock.wasWellKnown = true;
    else if (clock.wasWellKnown || this.isOverdue(fit.node, nowMs)) this.add("SYNC", AlarmCause.ClockPoor, where, 1, nowMs);
  }

  /** Takes each level: the next may be without what this one says. */
  overload(level: Level, atMs: number): void {
    for (let channel = 0; channel < level.peak.length; ++channel) {
      const where = `channel ${level.node}.${channel + 1}`;
      if ((level.overload >> channel) & 1) this.add("OVERLOAD", AlarmCause.Overload, where, 1, atMs);
      if (isClipped(level, channel)) this.add("OVERLOAD", AlarmCause.Clipped, where, 1, atMs);
    }
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
    if (count <= before) return;  // late messages, too
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
