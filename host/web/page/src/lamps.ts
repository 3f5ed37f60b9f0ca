// Four lamps with numbers.  A lamp stays lit until it is acknowledged, even if its cause is gone.
import {lightOf} from "./alarm";
import {isBusy, isFresh, type Car} from "./car";
import {faultyChannels} from "./channel_faults";
import {wantsClock, withoutDevice, type Event, type EventLog, type LampName} from "./events";
import {absent} from "./state";
import {AlarmCause, ClockState, kWantedSync_s, TimeBase, type Heartbeat} from "./wire";

const kCauses: Readonly<Record<LampName, AlarmCause>> = {
  LOSS: AlarmCause.SamplesLost, SYNC: AlarmCause.ClockBroken, OVERLOAD: AlarmCause.Overload, ENCODER: AlarmCause.FaultyTurns};
/** What lights it at worst. */
export const causeOf = (lamp: LampName) => kCauses[lamp];

export type Light = "good" | "unknown" | "warn" | "bad";

export interface Lamp {
  readonly name: string;
  readonly light: Light;
  /** "0 lost, 3 repaired" */
  readonly number: string;
  /** What it means, and the remedy. */
  readonly sentence: string;
}

const micro = (seconds: number) => `${Math.ceil(seconds * 1e6)} µs`;
const kWanted = micro(kWantedSync_s);

export const kWrongMarksRemedy = "Is a second magnet or the head of a bolt a mark, too, or pulses_per_turn wrong?";
/** "60 and 36": the teeth between zero marks of a line that name no tooth; empty: they do. */
export const wrongMarks = (beat: Heartbeat, line: number) =>
  beat.mark_counts.slice(2 * line, 2 * line + 2).filter((count) => count > 0).join(" and ");

const beats = (car: Car) => [...car.heartbeats.values()].map(({message}) => message);
const sum = (counts: readonly number[]) => counts.reduce((a, b) => a + b, 0);
const times = (count: number, one: string, many: string) => `${count} ${count === 1 ? one : many}`;
/** "node 1, node 2" */
const places = (events: readonly Event[]) => [...new Set(events.map(({where}) => where))].sort().join(", ");

const nodes = (found: readonly {readonly node: number}[]) =>
  `node${found.length > 1 ? "s" : ""} ${found.map(({node}) => node).join(", ")}`;

function lossLamp(car: Car, log: EventLog, nowMs: number): Lamp {
  const gone = log.total("LOSS");
  const repaired = sum(beats(car).map((beat) => beat.blocks_repaired));
  const number = `${gone} lost, ${repaired} repaired`;
  if (car.heartbeats.size === 0) return {name: "LOSS", light: "unknown", number: "no node", sentence: "No node is heard."};
  const recording = car.livingRecorders(nowMs).filter(isBusy);
  const away = recording.flatMap((recorder) => Array.from({length: recorder.absent}, (_, k) => ({node: recorder.absent_node[k] ?? 0})));
  if (away.length > 0)
    return {name: "LOSS", light: lightOf(AlarmCause.NodeMissing), number: `${nodes(away)} missing`,
            sentence: recording.flatMap(absent).join(" ")};
  const without = withoutDevice(car);
  if (without.length > 0)
    return {name: "LOSS", light: lightOf(AlarmCause.DeviceGone), number: `${nodes(without)}: device gone`,
            sentence: `A device of ${nodes(without)} is gone, and what it would measure is lost: look at its cable and supply.`};
  const found = log.unseen("LOSS");
  if (found.length > 0)
    return {name: "LOSS", light: lightOf(causeOf("LOSS")), number,
            sentence: `${times(gone, "sample is", "samples are")} lost for good in ${places(found)}, each declared in the ` +
              "record: look at the node's device and supply."};
  const failing = beats(car).filter((beat) => beat.spool_failures > 0);
  if (failing.length > 0)
    return {name: "LOSS", light: lightOf(AlarmCause.SpoolFailing), number,
            sentence: `The disk of ${nodes(failing)} refuses: what it holds is in its memory only.`};
  if (recording.length === 0)
    return {name: "LOSS", light: "good", number, sentence: "Nothing is lost; nothing is recorded now."};
  return {name: "LOSS", light: "good", number, sentence: "Every sample taken is recorded or on its way."};
}

/** How clocks stand now. */
function clocksNow(car: Car, log: EventLog, nowMs: number): Lamp {
  const name = "SYNC";
  if (car.heartbeats.size > 0 && beats(car).every((beat) => beat.time_base === TimeBase.Shared))
    return {name, light: "good", number: "one common clock", sentence: "All nodes have one common clock by construction: a simulation."};
  if (!car.livingRecorders(nowMs).some(isBusy))
    return {name, light: "unknown", number: "not asked", sentence: "Clocks are asked for their time while a recording is under way."};
  const fits = [...car.clocks.values()].filter((heard) => isFresh(heard, nowMs)).map(({message}) => message);
  const known = fits.filter((fit) => fit.state !== ClockState.Acquire);
  const unheard = [...known.filter((fit) => fit.state === ClockState.Holdover),
                   ...beats(car).filter((beat) => wantsClock(beat) && log.isOverdue(beat.node, nowMs) && !known.some(({node}) => node === beat.node))];
  const worst = known.reduce((a, b) => (b.uncertainty_s > a.uncertainty_s ? b : a), known[0] ?? {node: 0, uncertainty_s: 0});
  const number = known.length > 0 ? micro(worst.uncertainty_s) : "not heard";
  if (unheard.length > 0)
    return {name, light: lightOf(AlarmCause.ClockUnheard), number, sentence: `The clock of ${nodes(unheard)} is not heard: look at the network.`};
  if (known.length === 0) return {name, light: "unknown", number: "not known", sentence: "No clock is known yet."};
  if (known.length < fits.length || worst.uncertainty_s > kWantedSync_s)
    return {name, light: lightOf(AlarmCause.ClockPoor), number, sentence: `Node ${worst.node} is known to ${number}; ${kWanted} are wanted: wait, or ` +
              "look at the network."};
  return {name, light: "good", number, sentence: `Every clock is known to ${number}.`};
}

function syncLamp(car: Car, log: EventLog, nowMs: number): Lamp {
  const name = "SYNC";
  const unseen = log.unseen("SYNC");
  const broken = unseen.filter(({cause}) => cause === AlarmCause.ClockBroken);
  if (broken.length > 0)
    return {name, light: lightOf(causeOf("SYNC")), number: times(sum(broken.map(({count}) => count)), "break", "breaks"),
            sentence: `The clock of ${places(broken)} has jumped; the break is declared in the record.`};
  const now = clocksNow(car, log, nowMs);
  const [newest] = unseen;
  if (!newest || now.light === "warn") return now;
  return {name, light: lightOf(newest.cause), number: now.number,
          sentence: `${places(unseen)}: ${[...new Set(unseen.map(sentenceOf))].join("; ")}. ${now.sentence}`};
}

function overloadLamp(car: Car, log: EventLog, nowMs: number): Lamp {
  const name = "OVERLOAD";
  if (car.levels.size === 0) return {name, light: "unknown", number: "no levels", sentence: "No analyser is heard."};
  const found = log.unseen("OVERLOAD");
  const {dead, railed} = faultyChannels(car, nowMs);
  const faults = [...(dead.length > 0 ? [`${dead.length} dead`] : []), ...(railed.length > 0 ? [`${railed.length} DC offset`] : [])];
  const what = [
    ...(dead.length > 0 ? [`Channel ${dead.join(", ")} (node.channel) carries no signal: look at its cable and supply.`] : []),
    ...(railed.length > 0 ? [`Channel ${railed.join(", ")} (node.channel) stands far off its zero: look at its supply, then take ` +
                             "the zero again."] : [])].join(" ");
  if (found.length === 0 && faults.length > 0) return {name, light: lightOf(AlarmCause.DeadChannel), number: faults.join(", "), sentence: what};
  if (found.length === 0)
    return {name, light: "good", number: "0 channels", sentence: "No channel has left its range; none is known to be clipped or dead."};
  const of = (events: readonly Event[]) =>
    [...new Set(events.map(({where}) => where.replace("channel ", "")))].sort((a, b) => Number(a) - Number(b));
  const channels = of(found);
  const beyond = of(found.filter(({cause}) => cause === AlarmCause.Overload)), clipped = of(found.filter(({cause}) => cause === AlarmCause.Clipped));
  const sentences = [
    ...(beyond.length > 0 ? [`Channel ${beyond.join(", ")} (node.channel) has left its range: choose a larger range.`] : []),
    ...(clipped.length > 0 ? [`Channel ${clipped.join(", ")} (node.channel) is clipped, its tops are cut off at one value: ` +
                              "choose a larger range, or a sensor that has one."] : []),
    ...(what ? [what] : [])];
  const agoS = Math.round((nowMs - Math.max(...found.map(({lastMs}) => lastMs))) / 1000);
  return {name, light: lightOf(causeOf("OVERLOAD")), number: `${times(channels.length, "channel", "channels")}, ${agoS < 2 ? "now" : `${agoS} s ago`}`,
          sentence: sentences.join(" ")};
}

function encoderLamp(car: Car, log: EventLog): Lamp {
  const name = "ENCODER";
  if (car.heartbeats.size === 0) return {name, light: "unknown", number: "no node", sentence: "No node is heard."};
  const number = times(log.total("ENCODER"), "faulty turn", "faulty turns");
  const wrong = beats(car).flatMap((beat) => [0, 1].flatMap((line) => {
    const counts = wrongMarks(beat, line);
    return counts ? [`node ${beat.node} line ${line + 1}: ${counts} teeth`] : [];
  }));
  if (wrong.length > 0)
    return {name, light: lightOf(AlarmCause.WrongMarks), number: "zero marks name no tooth",
            sentence: `No angle: between zero marks lie, ${wrong.join("; ")}. ${kWrongMarksRemedy}`};
  const found = log.unseen("ENCODER");
  if (found.length === 0) return {name, light: "good", number, sentence: "Every turn has all its teeth."};
  const lines = beats(car).flatMap((beat) =>
    beat.encoder_faults.flatMap((count, line) => (count > 0 ? [`node ${beat.node} line ${line + 1}: ${count}`] : [])));
  return {name, light: lightOf(causeOf("ENCODER")), number,
          sentence: `Teeth missed or extra (${lines.length > 0 ? lines.join("; ") : places(found)}): ` +
            "look at the sensor's gap and its cable."};
}

export function lamps(car: Car, log: EventLog, nowMs: number): Lamp[] {
  return [lossLamp(car, log, nowMs), syncLamp(car, log, nowMs), overloadLamp(car, log, nowMs), encoderLamp(car, log)];
}

/** What there may be of it, counted or not, and the remedy. */
const kWords: Readonly<Partial<Record<AlarmCause, {readonly one: string; readonly many?: string; readonly remedy: string}>>> = {
  [AlarmCause.SamplesLost]: {one: "sample lost", many: "samples lost", remedy: "declared in the record; look at the node's device, cable and supply"},
  [AlarmCause.ClockBroken]: {one: "break of its clock", many: "breaks of its clock",
                             remedy: "declared in the record; look at the node's network, and whether its computer slept"},
  [AlarmCause.ClockUnheard]: {one: "clock not heard", remedy: "look at the node's network"},
  [AlarmCause.ClockPoor]: {one: `clock known worse than to ${kWanted}`, remedy: "look at the node's network"},
  [AlarmCause.Overload]: {one: "left its range", remedy: "choose a larger range, or mount the sensor more firmly"},
  [AlarmCause.Clipped]: {one: "clipped", remedy: "choose a larger range, or a sensor that has one"},
  [AlarmCause.FaultyTurns]: {one: "faulty turn", many: "faulty turns", remedy: "look at the sensor's gap and its cable"},
};

/** What, how much, and the remedy. */
export function sentenceOf({cause, count}: Event): string {
  const words = kWords[cause];
  if (!words) return "";
  const {one, many, remedy} = words;
  return `${many === undefined ? one : `${count.toLocaleString("en")} ${count === 1 ? one : many}`}: ${remedy}`;
}
