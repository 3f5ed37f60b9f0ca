// The results of tap tests: which channel is which, and whether its sign is right.  A person chooses beforehand which
// sensor is tapped: the loudest channel of a tap proves nothing by itself.
import type {Car} from "./car";
import {axisOf, signOf} from "./directions";
import {kAccelerations} from "./level_view";
import type {Knock, Setup} from "./wire";

export type Tap = "right" | "wrong";

/** Outlives a reload; another vehicle.toml begins anew. */
const kKept = "taps";

/** A channel that feels so much of what the loudest feels may be the one knocked. */
const kAlsoFelt = 0.5;

export interface Place {
  readonly node: number;
  readonly channel: number;
}

/** A knock, and what became of it when it was felt. */
export interface Felt {
  readonly setup: Setup;
  readonly knock: Knock;
  /** What was to be knocked on. */
  readonly meant: Place | undefined;
  readonly proves: boolean;
}

export class Taps {
  /** What will be knocked on next. */
  meant: Place | undefined;
  last: Felt | undefined;
  private readonly found: Map<string, Tap>;
  private readonly taken = new Map<number, number>();

  constructor() {
    this.found = new Map(JSON.parse(sessionStorage.getItem(kKept) ?? "[]") as [string, Tap][]);
  }

  of(setup: Setup, channel: number): Tap | undefined {
    return this.found.get(key(setup, channel));
  }

  /** Takes knocks that are new. */
  take(car: Car): void {
    for (const [node, {message: knock}] of car.knocks) {
      const setup = car.setups.get(node)?.message;
      if (!setup || this.taken.get(node) === knock.number) continue;
      this.taken.set(node, knock.number);
      const proves = this.meant?.node === node && this.meant.channel === knock.channel && alsoFelt(setup, knock).length === 0;
      this.last = {setup, knock, meant: this.meant, proves};
      if (!proves) continue;
      this.found.set(key(setup, knock.channel), isRight(setup, knock) ? "right" : "wrong");
      sessionStorage.setItem(kKept, JSON.stringify([...this.found]));
    }
  }
}

const key = (setup: Setup, channel: number) => `${setup.vehicle_crc32c} ${setup.node}.${channel}`;

/** A knock the positive way along the axis must show the sign of the sensor's direction there. */
export function isRight(setup: Setup, knock: Knock): boolean {
  return Math.sign(knock.first_m_s2[knock.channel] ?? 0) === signOf(setup.direction[knock.channel] ?? [0, 0, 1]);
}

/** Channels beside the loudest that felt nearly as much of it, along the same axis. */
export function alsoFelt(setup: Setup, knock: Knock): number[] {
  const loudest = knock.peak_m_s2[knock.channel] ?? 0;
  const axis = axisOf(setup.direction[knock.channel] ?? []);
  return Array.from({length: Math.min(setup.channels, kAccelerations)}, (_, channel) => channel).filter((channel) =>
    channel !== knock.channel && axisOf(setup.direction[channel] ?? []) === axis &&
    (knock.peak_m_s2[channel] ?? 0) > kAlsoFelt * loudest);
}
