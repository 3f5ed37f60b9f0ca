// The state of the car: the newest of every message, and when it was on the bus.
import {decode, readFrame, type Arrival} from "./decode";
import {isClipped} from "./channel_faults";
import {EventLog} from "./events";
import {Documents} from "./jobs";
import {PlotData} from "./plot_data";
import {
  type Answer, type Balance, type ClockFit, type Compensation, type Heartbeat, type Identification, kAnswer, kBalance, kClockFit,
  kCompensation, kDocument, kHeartbeat, kIdentification, kJob, kKnock, kLevel, kReceipt, kRecorder, kRecording, kRemark, kSetup, kVerification,
  type Job, type Knock, type Level, type Receipt, type Recorder, type Recording, type Remark, type Setup, type Verification,
} from "./wire";

/** A message and the page's time (ms) at which it was on the bus. */
export interface Heard<T> {
  readonly message: T;
  readonly atMs: number;
}

/** A state is said twice a second or more; in silence for so long nobody says it any more. */
export const kSilenceMs = 3000;
/** So long a peak is held and an overload shown as present. */
const kHoldMs = 3000;
/** As rb-web: a node or recorder that is silent is a fault until somebody has had time to see it. */
const kForgetMs = 3_600_000;

const kMostAnswers = 64;

/** Largest value of late, of a channel. */
interface Peak {
  value: number;
  atMs: number;
}

export class Car {
  readonly recorders = new Map<number, Heard<Recorder>>();
  readonly heartbeats = new Map<number, Heard<Heartbeat>>();
  readonly clocks = new Map<number, Heard<ClockFit>>();
  readonly levels = new Map<number, Heard<Level>>();
  /** By the request's number. */
  readonly answers = new Map<number, Answer>();
  /** Of the recording that was stopped last, by place. */
  readonly receipts = new Map<number, Heard<Receipt>>();
  readonly balance = new Map<number, Heard<Balance>>();
  readonly compensation = new Map<number, Heard<Compensation>>();
  identification: Heard<Identification> | undefined;
  readonly remarks = new Map<number, Heard<Remark>>();
  readonly knocks = new Map<number, Heard<Knock>>();
  readonly setups = new Map<number, Heard<Setup>>();
  readonly weightChecks = new Map<number, Heard<Verification>>();
  readonly recordings = new Map<number, Heard<Recording>>();
  /** By place. */
  readonly jobs = new Map<number, Heard<Job>>();
  readonly documents = new Documents();
  /** By "node.channel", counted from 1: when it last left its range. */
  readonly overloadMs = new Map<string, number>();
  readonly clippedMs = new Map<string, number>();
  readonly peaks = new Map<string, Peak>();
  /** What lights a lamp: taken with each frame, for a page in the background is not drawn. */
  readonly events = new EventLog();
  readonly plots = new PlotData();
  /** Incarnation of the recorder that was heard to record last. */
  private recording: number | undefined;
  /** Messages of no type that this page knows: the program is of another version. */
  strangers = 0;

  /** Takes a frame that came now. */
  take(frame: ArrayBuffer, nowMs: number): void {
    for (const arrival of readFrame(frame)) this.takeOne(arrival, nowMs - arrival.ageMs);
    for (const states of [this.recorders, this.heartbeats, this.clocks, this.levels, this.setups, this.recordings, this.jobs])
      for (const [key, heard] of states) if (nowMs - heard.atMs > kForgetMs) states.delete(key);
    this.events.take(this, nowMs);
  }

  private takeOne(arrival: Arrival, atMs: number): void {
    switch (arrival.fingerprint) {
      case kRecorder.fingerprint: {
        const message = decode(kRecorder, arrival);
        this.recorders.set(message.recorder, {message, atMs});
        this.noteRecording(message);
        break;
      }
      case kHeartbeat.fingerprint: {
        const message = decode(kHeartbeat, arrival);
        this.heartbeats.set(message.node, {message, atMs});
        break;
      }
      case kClockFit.fingerprint: {
        const message = decode(kClockFit, arrival);
        this.clocks.set(message.node, {message, atMs});
        break;
      }
      case kAnswer.fingerprint: this.takeAnswer(decode(kAnswer, arrival)); break;
      case kReceipt.fingerprint: this.takeReceipt(decode(kReceipt, arrival), atMs); break;
      case kLevel.fingerprint: this.takeLevel(decode(kLevel, arrival), atMs, arrival.ageMs <= kSilenceMs); break;
      case kBalance.fingerprint: {
        const message = decode(kBalance, arrival);
        this.balance.set(message.wheel, {message, atMs});
        break;
      }
      case kCompensation.fingerprint: {
        const message = decode(kCompensation, arrival);
        this.compensation.set(message.wheel, {message, atMs});
        break;
      }
      case kRemark.fingerprint: {
        const message = decode(kRemark, arrival);
        this.remarks.set(message.number, {message, atMs});
        break;
      }
      case kKnock.fingerprint: {
        const message = decode(kKnock, arrival);
        this.knocks.set(message.node, {message, atMs});
        break;
      }
      case kSetup.fingerprint: {
        const message = decode(kSetup, arrival);
        this.setups.set(message.node, {message, atMs});
        break;
      }
      case kVerification.fingerprint: {
        const message = decode(kVerification, arrival);
        this.weightChecks.set(message.wheel, {message, atMs});
        break;
      }
      case kRecording.fingerprint: {
        const message = decode(kRecording, arrival);
        this.recordings.set(message.number, {message, atMs});
        break;
      }
      case kJob.fingerprint: {
        const message = decode(kJob, arrival);
        this.jobs.set(message.place, {message, atMs});
        break;
      }
      case kDocument.fingerprint: this.documents.take(decode(kDocument, arrival)); break;
      case kIdentification.fingerprint: this.identification = {message: decode(kIdentification, arrival), atMs}; break;
      default: if (!this.plots.take(arrival)) ++this.strangers;
    }
  }

  private noteRecording(message: Recorder): void {
    if (!isBusy(message) || message.incarnation === this.recording) return;
    if (this.recording !== undefined) this.plots.begin();
    this.recording = message.incarnation;
  }

  private takeAnswer(message: Answer): void {
    this.answers.delete(message.request);  // the newest is the last
    this.answers.set(message.request, message);
    const [oldest] = this.answers.keys();
    if (this.answers.size > kMostAnswers && oldest !== undefined) this.answers.delete(oldest);
  }

  private takeReceipt(message: Receipt, atMs: number): void {
    const [other] = this.receipts.values();
    if (other && other.message.ended_us > message.ended_us) return;
    if (other && other.message.ended_us < message.ended_us) this.receipts.clear();
    this.receipts.set(message.index, {message, atMs});
  }

  private takeLevel(message: Level, atMs: number, isNews: boolean): void {
    this.levels.set(message.node, {message, atMs});
    if (isNews) this.events.overload(message, atMs);
    message.peak.forEach((peak, channel) => {
      const name = `${message.node}.${channel + 1}`;
      if ((message.overload >> channel) & 1) this.overloadMs.set(name, atMs);
      if (isClipped(message, channel)) this.clippedMs.set(name, atMs);
      const held = this.peaks.get(name);
      if (!held || peak >= held.value || atMs - held.atMs > kHoldMs) this.peaks.set(name, {value: peak, atMs});
    });
  }

  /** Recorders that live. */
  livingRecorders(nowMs: number): Recorder[] {
    return [...this.recorders.values()].filter((heard) => isFresh(heard, nowMs)).map((heard) => heard.message);
  }

  /** What there is to do about a wheel, of its newest balance. */
  advice(wheel: number): Compensation | undefined {
    const found = this.compensation.get(wheel)?.message;
    return found && found.time_ns === this.balance.get(wheel)?.message.time_ns ? found : undefined;
  }

  /** What weights have done to a wheel, of its newest balance: that of a recording before says nothing of this one. */
  weightCheckOf(wheel: number): Verification | undefined {
    const found = this.weightChecks.get(wheel)?.message;
    return found && found.time_ns === this.balance.get(wheel)?.message.time_ns ? found : undefined;
  }
}

/** A recording is under way, whatever its state. */
export const isBusy = (recorder: Recorder) => recorder.name_size > 0;

export function isFresh(heard: Heard<unknown>, nowMs: number): boolean {
  return nowMs - heard.atMs <= kSilenceMs;
}
