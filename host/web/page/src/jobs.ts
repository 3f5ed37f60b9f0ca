// The jobs of rb-recordings on a finished recording, and their documents.
import {utf8} from "./text";
import {JobKind, JobState, type Document as DocumentPart, type Job} from "./wire";
import {duration, localTime} from "./words";

export type JobForm = "report" | "export" | "select" | "reduce" | "transfer";

export interface JobLine {
  readonly kind: JobKind;
  readonly button: string;
  readonly does: string;
  /** Its button opens what it needs to know first. */
  readonly form?: JobForm;
  /** What beginning it again does. */
  readonly again?: string;
}

/** A line makes one more button. */
export const kJobs: readonly JobLine[] = [
  {kind: JobKind.Verify, button: "Verify", does: "Proof that it is complete"},
  {kind: JobKind.Identify, button: "Identify", does: "Balance of its drive"},
  {kind: JobKind.Report, button: "Report", does: "Report of its drive", form: "report", again: "Begin anew"},
  {kind: JobKind.Export, button: "Export", does: "File for another program", form: "export", again: "Begin anew"},
  {kind: JobKind.Select, button: "Select", does: "Recording of a part of it", form: "select", again: "Begin anew"},
  {kind: JobKind.Reduce, button: "Reduce", does: "Recording of fewer samples a second", form: "reduce", again: "Begin anew"},
  {kind: JobKind.Transfer, button: "Transfer", does: "Copy on another disk", form: "transfer", again: "Resume"},
];

/** As rb export calls them. */
export const kFormats: readonly (readonly [format: string, words: string])[] = [
  ["mdf4", "MDF4: vehicle measurement tools"], ["hdf5", "HDF5: MATLAB, Python, Octave"], ["mat", "MAT: MATLAB"],
  ["uff58", "UFF58: modal analysis"], ["wav", "WAV: audio tools"], ["csv", "CSV: any program"], ["mcap", "MCAP: Foxglove"],
  ["candump", "candump: CAN tools; with a DBC file beside it"],
];

/** "format=csv/from=3/channels=a,b" in words; empty: all of it. */
export function optionWords(options: string): string {
  const value = new Map(options.split("/").map((word) => {
    const equals = word.indexOf("=");
    return [word.slice(0, equals), word.slice(equals + 1)] as const;
  }));
  const end = (name: string) => {
    const [seconds, mark] = [value.get(name), value.get(`${name}-mark`)];
    if (seconds === undefined && mark === undefined) return [];
    return [`${name} ${seconds === undefined ? "" : `${seconds} s`}${mark === undefined ? "" : `${seconds === undefined ? "" : " after "}mark ${mark}`}`];
  };
  const of = (key: string, words: (text: string) => string) => {
    const found = value.get(key);
    return found === undefined ? [] : [words(found)];
  };
  return [...of("complete", () => "complete account"), ...of("before", (name) => `compared with “${name}”`), ...of("format", (name) => name), ...of("rate", (hz) => `${hz} Hz`),
          ...end("from"), ...end("to"), ...of("channels", (names) => `channels ${names}`)].join(", ");
}

/** "3.1 of about 9.3 GB read, 45 MB/s, about 00:02:18 left". */
export function paceWords({bytes, bytes_to_read, bytes_per_s}: Pick<Job, "bytes" | "bytes_to_read" | "bytes_per_s">): string {
  const [unit, name] = Math.max(bytes, bytes_to_read) >= 1e9 ? [1e9, "GB"] : [1e6, "MB"];
  const said = `${(bytes / unit).toFixed(1)} of about ${(Math.max(bytes, bytes_to_read) / unit).toFixed(1)} ${name} read`;
  if (!(bytes_per_s > 0)) return said;
  const left = bytes_to_read > bytes ? `about ${duration((bytes_to_read - bytes) / bytes_per_s)} left` : "nearly done";
  return `${said}, ${(bytes_per_s / 1e6).toFixed(bytes_per_s < 1e7 ? 1 : 0)} MB/s, ${left}`;
}

/** "begun 2026-11-23 04:34:27, took 00:00:12".  How long it took is of a clock that nobody sets. */
export function whenWords({began_us, elapsed_s}: Pick<Job, "began_us" | "elapsed_s">, isUnderWay: boolean): string {
  if (!(began_us > 0)) return "";
  const took = !(elapsed_s > 0) ? "" : isUnderWay ? `, ${duration(elapsed_s)} so far` : elapsed_s < 1 ? ", took less than a second" : `, took ${duration(elapsed_s)}`;
  return `begun ${localTime(began_us)}${took}`;
}

export const kStates: Readonly<Record<JobState, readonly [tone: string, word: string]>> = {
  [JobState.Running]: ["quiet", "under way"],
  [JobState.Held]: ["warn", "waits: a recording is under way"],
  [JobState.Done]: ["good", "done"],
  [JobState.NotWell]: ["warn", "done, and not all is well"],
  [JobState.Failed]: ["bad", "failed"],
  [JobState.Cancelled]: ["quiet", "cancelled"],
  [JobState.Interrupted]: ["warn", "interrupted"],
};

/** As rb-recordings: that it tells at a time, and once more in case they change just now. */
const kMostDocuments = 16;

/** What jobs have written, from its parts. */
export class Documents {
  private readonly parts = new Map<number, (readonly number[] | undefined)[]>();

  take(part: DocumentPart): void {
    let known = this.parts.get(part.job);
    if (!known) {
      this.parts.set(part.job, known = Array.from({length: part.parts}, () => undefined));
      const [oldest] = this.parts.keys();
      if (this.parts.size > kMostDocuments && oldest !== undefined) this.parts.delete(oldest);
    }
    if (part.part < known.length) known[part.part] = part.bytes.slice(0, part.size);
  }

  /** Nothing: it is not whole yet. */
  text(job: number): string | undefined {
    const known = this.parts.get(job);
    if (!known || known.includes(undefined)) return undefined;
    const all = known.flatMap((bytes) => [...(bytes ?? [])]);
    return utf8(all, all.length);
  }
}
