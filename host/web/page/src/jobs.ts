// What rb-recordings can do with a finished recording, and what it has written.
import {utf8} from "./text";
import {JobKind, JobState, type Document as DocumentPart} from "./wire";

export interface JobLine {
  readonly kind: JobKind;
  readonly button: string;
  readonly does: string;
  /** It may be compared with another recording. */
  readonly takesBefore: boolean;
}

/** A line makes one more button. */
export const kJobs: readonly JobLine[] = [
  {kind: JobKind.Verify, button: "Verify", does: "Proof that it is complete", takesBefore: false},
  {kind: JobKind.Identify, button: "Identify", does: "Balance of its drive", takesBefore: false},
  {kind: JobKind.Report, button: "Report", does: "Report of its drive", takesBefore: true},
];

export const kStates: Readonly<Record<JobState, readonly [tone: string, word: string]>> = {
  [JobState.Running]: ["quiet", "under way"],
  [JobState.Held]: ["warn", "waits: a recording is under way"],
  [JobState.Done]: ["good", "done"],
  [JobState.NotWell]: ["warn", "done, and not all is well"],
  [JobState.Failed]: ["bad", "failed"],
  [JobState.Cancelled]: ["quiet", "cancelled"],
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
