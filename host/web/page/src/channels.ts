// The channels and their names.
import type {Car} from "./car";
import {untilZero} from "./text";
import {ChannelRole, type Setup} from "./wire";

/** A channel as messages name it; `channel` from 0. */
export interface ChannelId {
  readonly node: number;
  readonly channel: number;
}

/** "2.5": node and channel, counted from 1. */
export const channelKey = ({node, channel}: ChannelId) => `${node}.${channel + 1}`;

export function channelOfKey(key: string): ChannelId | undefined {
  const found = /^(\d+)\.(\d+)$/.exec(key);
  return found ? {node: Number(found[1]), channel: Number(found[2]) - 1} : undefined;
}

/** "2.5 fl_carrier_z": where its cable is, and what vehicle.toml calls it. */
export const placeAndName = (setup: Setup, channel: number) =>
  `${channelKey({node: setup.node, channel})} ${untilZero(setup.channel_name[channel] ?? [])}`;

/** What vehicle.toml calls it, or its number as long as no node has said so. */
export function channelName(car: Car, id: ChannelId): string {
  const setup = car.setups.get(id.node)?.message;
  const name = setup && id.channel < setup.channels ? untilZero(setup.channel_name[id.channel] ?? []) : "";
  return name || channelKey(id);
}

/** Accelerations of all nodes, in order. */
export function accelerations(car: Car): ChannelId[] {
  const nodes = new Set([...car.setups.keys(), ...car.levels.keys()]);
  return [...nodes].sort((a, b) => a - b).flatMap((node) => {
    const setup = car.setups.get(node)?.message;
    const count = setup ? setup.channels : 12;
    return Array.from({length: count}, (_, channel) => ({node, channel}))
      .filter(({channel}) => !setup || setup.role[channel] === ChannelRole.Acceleration);
  });
}

/** The upright one on the carrier of each wheel that has one; of cars that nobody described the first of each node. */
export function carriers(car: Car): ChannelId[] {
  const all = accelerations(car);
  const found = [0, 1, 2, 3].flatMap((wheel) => carrierOf(car, wheel) ?? []);
  return found.length > 0 ? found : all.filter(({channel}) => channel === 0);
}

/** The upright acceleration on a wheel's carrier. */
export function carrierOf(car: Car, wheel: number): ChannelId | undefined {
  return accelerations(car).find(({node, channel}) => {
    const setup = car.setups.get(node)?.message;
    return setup?.mount[channel] === wheel && Math.abs(setup.direction[channel]?.[2] ?? 0) > 0.7;
  });
}

/** Turns a second of a wheel, where a node tells them. */
export function rotationHz(car: Car, wheel: number): number | undefined {
  for (const [node, {message}] of car.levels) {
    const line = car.setups.get(node)?.message.wheel.indexOf(wheel) ?? -1;
    const hz = line < 0 ? Number.NaN : message.rotation_hz[line] ?? Number.NaN;
    if (Number.isFinite(hz)) return hz;
  }
  return undefined;
}
