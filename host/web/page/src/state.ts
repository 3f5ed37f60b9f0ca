// The state in one word: is it recording everything?
import {saying, type Saying} from "./alarm";
import {isFresh, type Car} from "./car";
import {utf8} from "./text";
import {AbsenceCause, AlarmCause, AlarmLevel, NodeState, RecorderState, type Heartbeat, type Recorder} from "./wire";

export type Alarm = "good" | "idle" | "warn" | "bad";

export interface StateWord {
  readonly alarm: Alarm;
  readonly word: string;
  /** What a person should know or do about it. */
  readonly detail: string;
  /** Seconds that it has been recording. */
  readonly recordingS?: number;
  readonly recorder?: Recorder;
}

const isOver = (beat: Heartbeat) => beat.state === NodeState.Ended || beat.state === NodeState.Failed;

// A new cause does not compile before it has its sentence here.
const kAbsent: Readonly<Record<AbsenceCause, string>> = {
  [AbsenceCause.None]: "for a reason that is not known.",
  [AbsenceCause.Stopped]: "it was stopped by a command that was not this recorder's.",
  [AbsenceCause.SourceOver]: "its source has no more.",
  [AbsenceCause.DeviceFailed]: "its device has failed: look at its cable and supply.",
  [AbsenceCause.ProgramEnded]: "its program was ended, by its service or a person: start it again.",
  [AbsenceCause.Silent]: "it is not heard: look at its cable and supply.",
  [AbsenceCause.NeverCame]: "it has not been heard: is it on, and its cable plugged in?",
};

/** Nodes that do not measure though they are to be recorded; empty: none. */
export function absent(recorder: Recorder): string[] {
  return Array.from({length: recorder.absent}, (_, k) =>
    `Node ${recorder.absent_node[k]} is not recorded: ${kAbsent[recorder.absent_cause[k] as AbsenceCause] ?? kAbsent[AbsenceCause.None]}`);
}

function ofRecorder(car: Car, recorder: Recorder, nowMs: number): StateWord {
  if (recorder.state === RecorderState.Fault)
    return {alarm: "bad", word: "FAULT", recorder,
            detail: `Nothing is recorded: ${utf8(recorder.fault, recorder.fault_size)}. The nodes keep what they measure.`};
  if (recorder.state === RecorderState.DiskFailing)
    return {alarm: "bad", word: "FAULT", recorder,
            detail: `The disk fails (${recorder.disk_failures} times): ${utf8(recorder.fault, recorder.fault_size)}. The nodes keep what they measure.`};
  if (recorder.state === RecorderState.DiskFull)
    return {alarm: "bad", word: "FAULT", recorder,
            detail: "The disk is full. The nodes keep what they measure: make space."};
  if (recorder.state === RecorderState.Idle)
    return {alarm: "idle", word: "IDLE", recorder, detail: "No node is there to be recorded: look at cables and supply."};
  if (recorder.state === RecorderState.Armed)
    return {alarm: "idle", word: "ARMED", recorder,
            detail: recorder.nodes === 1 ? "1 node waits for the start." : `${recorder.nodes} nodes wait for the start.`};
  const own = [...car.heartbeats.values()].filter(({message}) => message.owner === recorder.incarnation);
  const silent = own.filter((heard) => !isFresh(heard, nowMs) && !isOver(heard.message));
  if (silent.length > 0)
    return {alarm: "bad", word: "FAULT", recorder,
            detail: `Node ${silent.map(({message}) => message.node).join(", ")} is silent: look at its cable and supply.`};
  const failed = own.filter(({message}) => message.state === NodeState.Failed);
  if (failed.length > 0)
    return {alarm: "bad", word: "FAULT", recorder,
            detail: `The device of node ${failed.map(({message}) => message.node).join(", ")} has failed.`};
  if (recorder.absent > 0) return {alarm: "bad", word: "FAULT", recorder, detail: absent(recorder).join(" ")};
  if (recorder.left_out > 0)
    return {alarm: "bad", word: "FAULT", recorder, detail: `Node ${recorder.left_out} is not recorded: there is room for no more nodes.`};
  if (recorder.state === RecorderState.Stopping)
    return {alarm: "idle", word: "STOPPING", detail: "The last blocks are written.", recorder};
  if (own.some(({message}) => message.state === NodeState.Started))
    return {alarm: "good", word: "RECORDING", detail: "", recorder,
            recordingS: Math.max(0, recorder.recording_s)};
  if (own.some(({message}) => message.state === NodeState.Ended))
    return {alarm: "idle", word: "ENDED", detail: "Every node has ended.", recorder};
  return {alarm: "idle", word: "ARMED", detail: "A recorder waits for nodes.", recorder};
}

function withoutRecorder(car: Car, nowMs: number): StateWord {
  const beats = [...car.heartbeats.values()];
  const gone = [...car.recorders.values()].map(({message}) => message);
  const rests = ({state}: Recorder) =>
    [RecorderState.Stopping, RecorderState.Idle, RecorderState.Armed].includes(state as RecorderState);
  const inOrder = (recorder: Recorder) => rests(recorder) ||
    beats.every(({message}) => message.owner !== recorder.incarnation || isOver(message));
  if (gone.some((recorder) => !inOrder(recorder)))
    return {alarm: "bad", word: "FAULT",
            detail: "The recorder is silent. The nodes keep what they measure: start it again."};
  const running = beats.some((heard) => isFresh(heard, nowMs) && !isOver(heard.message));
  return {alarm: "idle", word: "IDLE",
          detail: running ? "Nothing is recorded: start a recorder."
            : gone.length > 0 ? "The recording has ended." : "No recorder and no node is heard."};
}

export type Connection = "open" | "lost" | "never";

/** @param connection  to rb-web */
export function stateWord(car: Car, connection: Connection, nowMs: number): StateWord {
  if (connection === "never")
    return {alarm: "bad", word: "NO CONNECTION",
            detail: "rb-web does not admit this page, or has not answered yet: open its whole address, with #token=…"};
  if (connection === "lost")
    return {alarm: "bad", word: "NO CONNECTION",
            detail: "This page does not reach rb-web: what it shows is old. The recording does not depend on it."};
  const recorders = car.livingRecorders(nowMs);
  const states = recorders.map((recorder) => ofRecorder(car, recorder, nowMs));
  const worst = states.find(({alarm}) => alarm === "bad") ?? states.find(({alarm}) => alarm === "good") ?? states[0];
  if (!worst) return withoutRecorder(car, nowMs);
  if (recorders.length > 1)
    return {...worst, alarm: "bad", detail: "More than one recorder: a node obeys only one of them. " + worst.detail};
  return worst;
}

/** Second lines, the worst first: what threatens though it is recorded still. */
export function warnings(car: Car, nowMs: number): Saying[] {
  const found: Saying[] = [];
  const add = (cause: AlarmCause, text: string) => found.push(saying(cause, text));
  const warn = (text: string) => found.push({level: AlarmLevel.Warning, text});
  for (const recorder of car.livingRecorders(nowMs)) {
    const saysItAlready = recorder.state === RecorderState.Fault || recorder.state === RecorderState.DiskFailing;
    if (recorder.fault_size > 0 && !saysItAlready)
      add(AlarmCause.RecorderSays, `${utf8(recorder.fault, recorder.fault_size)}.`);
    if (recorder.on_battery & 1) add(AlarmCause.SupplyGone, "The supply is gone: on battery.");
    if (recorder.on_battery & 2) add(AlarmCause.SupplyUnknown, "Whether the supply is there cannot be read.");
    if (recorder.fallback) add(AlarmCause.Fallback, "Records to the fallback folder: the first disk has failed.");
    if (recorder.rivals > 0) add(AlarmCause.Rivals, "Two nodes have one number, or one was paused.");
    if (recorder.seconds_left >= 0 && recorder.seconds_left < 3600 && recorder.state !== RecorderState.DiskFull)
      add(AlarmCause.DiskLow, `The disk is full in ${Math.floor(recorder.seconds_left / 60)} min.`);
  }
  const levels = [...car.levels.values()];
  if (levels.length > 0 && !levels.some((heard) => isFresh(heard, nowMs)) &&
      [...car.heartbeats.values()].some((heard) => isFresh(heard, nowMs) && heard.message.state === NodeState.Started))
    add(AlarmCause.AnalyserSilent, "The analyser is silent: levels and balance are old.");
  if (car.strangers > 0) warn("rb-web is of another version than this page: load it again.");
  return found.sort((a, b) => b.level - a.level);
}
