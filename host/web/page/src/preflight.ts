// Is everything ready to record?  Each point has its remedy.
import {isBusy, isFresh, type Car} from "./car";
import {faultOf, isClipped, isDead, isRailed} from "./channel_faults";
import {placeAndName} from "./channels";
import {oppositePairs} from "./directions";
import {EventLog, withoutDevice} from "./events";
import {kWrongMarksRemedy, lamps, wrongMarks} from "./lamps";
import {kAccelerations} from "./level_view";
import type {Taps} from "./taps";
import {untilZero} from "./text";
import {kWheelNames} from "./wheel_place";
import {ChannelRole, type Setup} from "./wire";

export type Ready = "yes" | "no" | "unknown";

export interface Check {
  readonly name: string;
  readonly ready: Ready;
  /** What was found; if it is not right, what to do. */
  readonly says: string;
}

/** So much room is wanted before a drive. */
const kRoomS = 3600;

const freshSetups = (car: Car, nowMs: number) =>
  [...car.setups.values()].filter((heard) => isFresh(heard, nowMs)).map(({message}) => message).sort((a, b) => a.node - b.node);
const usedChannels = (setup: Setup) => Array.from({length: Math.min(setup.channels, kAccelerations)}, (_, channel) => channel)
  .filter((channel) => setup.role[channel] !== ChannelRole.Unused);

function nodes(setups: readonly Setup[], car: Car, nowMs: number): Check {
  const name = "Nodes";
  const silent = [...car.setups.values()].filter((heard) => !isFresh(heard, nowMs)).map(({message}) => message);
  if (silent.length > 0)
    return {name, ready: "no", says: `Node ${silent.map(({node}) => node).join(", ")} is silent: look at its supply and cable.`};
  const without = withoutDevice(car);
  if (without.length > 0)
    return {name, ready: "no", says: `A device of node ${without.map(({node}) => node).join(", ")} is gone: look at its cable and supply.`};
  if (setups.length === 0) return {name, ready: "no", says: "No node is heard: start rb-node; rb doctor says what is wrong with the network."};
  return {name, ready: "yes", says: setups.map((setup) => `${setup.node} ${untilZero(setup.name)}`).join(", ")};
}

function vehicleFile(setups: readonly Setup[]): Check {
  const name = "Vehicle file";
  if (setups.length === 0) return {name, ready: "unknown", says: "No node has said what it is."};
  if (new Set(setups.map(({vehicle_crc32c}) => vehicle_crc32c)).size > 1)
    return {name, ready: "no", says: "The nodes have different vehicle.toml: copy one and the same file to each, and start them again."};
  const wheels = new Set(setups.flatMap(({wheel}) => wheel).filter((wheel) => wheel >= 0));
  const without = kWheelNames.filter((_, wheel) => !wheels.has(wheel));
  if (without.length > 0)
    return {name, ready: "no", says: `No node that is heard has the encoder of: ${without.join(", ")}. Its balance will not be known.`};
  return {name, ready: "yes", says: `${untilZero(setups[0]?.vehicle ?? [])}: the same on all nodes, an encoder for each wheel.`};
}

function channels(setups: readonly Setup[], car: Car, nowMs: number): Check {
  const name = "Channels";
  const levels = [...car.levels.values()].filter((heard) => isFresh(heard, nowMs)).map(({message}) => message);
  if (levels.length === 0) return {name, ready: "unknown", says: "No levels are heard: they come with a recording. If one is under way, start rb-analyser."};
  const bad = setups.flatMap((setup) => {
    const level = levels.find(({node}) => node === setup.node);
    if (!level) return [`node ${setup.node}: no levels`];
    return usedChannels(setup).filter((channel) => faultOf(level, channel) || (level.overload >> channel) & 1 || isClipped(level, channel))
      .map((channel) => `${placeAndName(setup, channel)} ${isDead(level, channel) ? "carries no signal" :
        isRailed(level, channel) ? `stands ${(level.mean[channel] ?? 0).toPrecision(2)} m/s² off its zero` :
        (level.overload >> channel) & 1 ? "is beyond its range" : "is clipped"}`);
  });
  if (bad.length > 0) return {name, ready: "no", says: `${bad.join("; ")}: look at cable, supply, sensor and range.`};
  const count = setups.reduce((sum, setup) => sum + usedChannels(setup).length, 0);
  return {name, ready: "yes", says: `All ${count} are alive and within their range.`};
}

function directions(setups: readonly Setup[], taps: Taps): Check {
  const name = "Directions";
  const all = setups.flatMap((setup) => usedChannels(setup).map((channel) => ({setup, channel, tap: taps.of(setup, channel)})));
  const wrong = all.filter(({tap}) => tap === "wrong");
  if (wrong.length > 0)
    return {name, ready: "no", says: `${wrong.map(({setup, channel}) => placeAndName(setup, channel)).join(", ")}: ` +
      "the knock came with the wrong sign: correct direction in vehicle.toml, or swap the two wires."};
  const doubtful = setups.flatMap((setup) => oppositePairs(setup)
    .filter(([left, right]) => !taps.of(setup, left) || !taps.of(setup, right))
    .map(([left, right]) => `${placeAndName(setup, left)} and ${placeAndName(setup, right)}`));
  if (doubtful.length > 0)
    return {name, ready: "unknown", says: `Left and right are described as opposite: ${doubtful.join("; ")}. Knock on both: is it so?`};
  const proven = all.filter(({tap}) => tap === "right").length;
  return {name, ready: all.length > 0 && proven === all.length ? "yes" : "unknown",
          says: `${proven} of ${all.length} are proven by a knock.`};
}

function encoders(setups: readonly Setup[], car: Car): Check {
  const name = "Encoders";
  const beats = setups.flatMap(({node}) => car.heartbeats.get(node)?.message ?? []);
  const lines = setups.flatMap((setup) => setup.wheel.flatMap((wheel, line) => (wheel >= 0 ? [{setup, wheel, line}] : [])));
  const wrong = lines.flatMap(({setup, wheel, line}) => {
    const beat = beats.find(({node}) => node === setup.node);
    const counts = beat ? wrongMarks(beat, line) : "";
    return counts ? [`${kWheelNames[wheel]}: ${counts}`] : [];
  });
  if (wrong.length > 0)
    return {name, ready: "no", says: `Teeth between zero marks of ${wrong.join("; ")}. ${kWrongMarksRemedy}`};
  const faulty = lines.filter(({setup, line}) => (beats.find(({node}) => node === setup.node)?.encoder_faults[line] ?? 0) > 0);
  if (faulty.length > 0)
    return {name, ready: "no", says: `${faulty.map(({wheel}) => kWheelNames[wheel]).join(", ")}: teeth missed or extra: ` +
      "look at the sensor's gap, its cable and pulses_per_turn."};
  const still = lines.filter(({setup: {node}}) => !Number.isFinite(car.levels.get(node)?.message.speed_m_s ?? NaN));
  if (still.length > 0 || lines.length === 0)
    return {name, ready: "unknown", says: "Drive a few turns of the wheels: not every node has an angle yet."};
  return {name, ready: "yes", says: `${lines.length} give whole turns.`};
}

/** None before the start: recorders ask clocks for their time while they record. */
function clocks(car: Car, nowMs: number): Check[] {
  const lamp = lamps(car, new EventLog(), nowMs).find((each) => each.name === "SYNC");
  const ready = {good: "yes", unknown: "unknown", warn: "no", bad: "no"} as const;
  if (lamp?.light === "unknown" && !car.livingRecorders(nowMs).some(isBusy)) return [];
  return [{name: "Clocks", ready: ready[lamp?.light ?? "unknown"], says: lamp?.sentence ?? ""}];
}

function disk(car: Car, nowMs: number): Check {
  const name = "Disk";
  const [recorder] = car.livingRecorders(nowMs);
  if (!recorder) return {name, ready: "no", says: "No recorder is heard: start rb-recorder."};
  const free = `${(recorder.bytes_free / 1e9).toFixed(1)} GB free`;
  if (recorder.seconds_left < 0) return {name, ready: recorder.bytes_free > 0 ? "yes" : "no", says: `${free}; how long that lasts shows while it records.`};
  if (recorder.seconds_left < kRoomS) return {name, ready: "no", says: `${free}: room for ${Math.floor(recorder.seconds_left / 60)} min: make space.`};
  return {name, ready: "yes", says: `${free}: room for ${(recorder.seconds_left / 3600).toFixed(1)} h.`};
}

export function preflight(car: Car, taps: Taps, nowMs: number): Check[] {
  const setups = freshSetups(car, nowMs);
  return [nodes(setups, car, nowMs), vehicleFile(setups), channels(setups, car, nowMs), directions(setups, taps),
          encoders(setups, car), ...clocks(car, nowMs), disk(car, nowMs)];
}
