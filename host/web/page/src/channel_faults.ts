// The faults of a channel, by its level message.
import {isFresh, type Car} from "./car";
import {ChannelRole, type Level} from "./wire";

const kChannels = 16;

/** No signal: not a count of noise, or next to nothing while its neighbours move. */
export const isDead = (level: Level, channel: number) => ((level.dead >> channel) & 1) === 1;
/** Its mean is where none can be: no supply, a broken bias, a shifted zero. */
export const isRailed = (level: Level, channel: number) => ((level.dead >> (kChannels + channel)) & 1) === 1;
/** At a value beyond which it is cut off, whatever its range. */
export const isClipped = (level: Level, channel: number) => ((level.clipped >> channel) & 1) === 1;
/** A word for a bar or a row; empty: nothing is wrong. */
export const faultOf = (level: Level, channel: number) =>
  isDead(level, channel) ? "dead" : isRailed(level, channel) ? "DC" : "";

/** Channels in use, "node.channel", that carry no signal, and that are far off their zero. */
export function faultyChannels(car: Car, nowMs: number): {dead: string[]; railed: string[]} {
  const dead: string[] = [], railed: string[] = [];
  for (const [node, heard] of [...car.levels].sort(([a], [b]) => a - b)) {
    if (!isFresh(heard, nowMs)) continue;
    const roles = car.setups.get(node)?.message.role;
    for (let channel = 0; channel < kChannels; ++channel) {
      if (roles?.[channel] === ChannelRole.Unused) continue;
      if (isDead(heard.message, channel)) dead.push(`${node}.${channel + 1}`);
      else if (isRailed(heard.message, channel)) railed.push(`${node}.${channel + 1}`);
    }
  }
  return {dead, railed};
}
