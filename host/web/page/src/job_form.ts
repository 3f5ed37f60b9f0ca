// The form for a job's options.  Folders are never typed here: the machine's operator has set them.
import {el, setText} from "./dom";
import {kFormats, type JobForm} from "./jobs";
import {untilZero} from "./text";
import {RecordingState, type Recording} from "./wire";

const kFactors = [2, 3, 4, 5, 8, 10, 20, 50, 100];

const rounded = (hz: number) => String(Number(hz.toPrecision(9)));

function reduceWords({most_reduction, rate_hz, cutoff_hz, state}: Recording, canBe: boolean): string {
  const least = `more than ${rounded(2 * cutoff_hz)} Hz must be left, twice the cutoff of the filter that it was recorded with`;
  if (canBe) return `Makes a recording of fewer samples, behind a low-pass that lets nothing fold; this one stays as it is. It has ${rounded(rate_hz)} Hz, and ${least}.`;
  if (most_reduction > 0) return `It has ${rounded(rate_hz)} samples a second and cannot be reduced: ${least}.`;
  return state === RecordingState.NotRead || state === RecordingState.Growing ? "How many samples a second it has will be known when it has been checked."
    : "It cannot be reduced: it does not say how many samples a second it has, and behind which filter.";
}

const secondsField = (words: string) => el("input", {type: "number", step: "any", placeholder: words, autocomplete: "off"});
const labelled = (name: string, field: HTMLElement) => el("label", {}, [el("span", {}, [name]), field]);
const option = (value: string, words: string) => el("option", {value}, [words]);

/** Choices that change only when what they are made of does: a choice that is open stays open. */
class Choice {
  readonly element = el("select");
  private offered = "";

  constructor(private readonly none: string) {}

  offer(choices: readonly (readonly [value: string, words: string])[]): void {
    const offered = choices.flat().join("\n");
    if (offered === this.offered && this.element.options.length > 0) return;
    this.offered = offered;
    const chosen = this.element.value;
    const all = [...(this.none === "" ? [] : [["", this.none] as const]), ...choices];
    this.element.replaceChildren(...all.map(([value, words]) => option(value, words)));
    if (all.some(([value]) => value === chosen)) this.element.value = chosen;
  }
}

/** The first is what nobody need say. */
const kExtents = [["", "one page: balance and proof"], ["yes", "complete account of the drive"]] as const;

const kAnother = "another";

/** A mark among those that are told, or any other by its number. */
class MarkChoice {
  private readonly told = new Choice("the first sample");
  private readonly number = el("input", {type: "number", min: "0", step: "1", placeholder: "its number", autocomplete: "off"});
  private readonly field: HTMLElement;
  readonly elements: HTMLElement[];

  constructor(name: string) {
    this.field = labelled("Number of the mark", this.number);
    this.elements = [labelled(name, this.told.element), this.field];
    this.told.element.onchange = () => this.show();
    this.show();
  }

  offer(recording: Recording): void {
    const known = Math.min(recording.marks, recording.mark.length);
    const marks = Array.from({length: known}, (_, k) => [String(recording.mark_number[k]),
      `mark ${recording.mark_number[k]}: ${untilZero(recording.mark[k] ?? []) || "–"}`] as const);
    this.told.offer(recording.marks > known ? [...marks, [kAnother, `one of the other ${recording.marks - known}: by its number`]] : marks);
    this.show();
  }

  get value(): string {
    return this.told.element.value === kAnother ? this.number.value : this.told.element.value;
  }

  private show(): void {
    const isAnother = this.told.element.value === kAnother;
    this.field.hidden = !isAnother;
    this.number.required = isAnother;
  }
}

/** One form for each kind that has one. */
export class JobFields {
  readonly element: HTMLElement;
  private readonly format = new Choice("");
  private readonly rate = new Choice("");
  private readonly extent = new Choice("");
  private readonly before = new Choice("nothing");
  private readonly from = secondsField("the beginning");
  private readonly to = secondsField("the end");
  private readonly fromMark = new MarkChoice("counted from");
  private readonly toMark = new MarkChoice("counted from");
  private readonly channels = el("input", {type: "text", placeholder: "all", autocomplete: "off", maxlength: "200"});
  private readonly words = el("p");

  constructor(private readonly form: JobForm) {
    this.format.offer(kFormats);
    this.extent.offer(kExtents);
    const times = form === "select"
      ? [labelled("From, s", this.from), ...this.fromMark.elements, labelled("To, s", this.to), ...this.toMark.elements]
      : [labelled("From, s", this.from), labelled("To, s", this.to)];
    const names = labelled("Channels or nodes, with commas between", this.channels);
    const fields = {
      report: [labelled("What", this.extent.element), labelled("Compared with", this.before.element)],
      export: [labelled("Format", this.format.element), ...times, names], select: [...times, names],
      reduce: [labelled("Samples a second", this.rate.element)], transfer: [],
    };
    this.element = el("div", {class: "fields"}, [this.words, ...fields[form]]);
  }

  /** @param transferTo  empty: nothing may be transferred
      @param others  recordings that it can be compared with
      @return it can begin */
  draw(recording: Recording, transferTo: string, others: readonly string[]): boolean {
    this.before.offer(others.map((name) => [name, name] as const));
    this.fromMark.offer(recording);
    this.toMark.offer(recording);
    const factors = kFactors.filter((factor) => factor <= recording.most_reduction);
    this.rate.offer(factors.map((factor) => {
      const hz = rounded(recording.rate_hz / factor);
      return [hz, `${hz} Hz: every ${factor}${["nd", "rd"][factor - 2] ?? "th"}`] as const;
    }));
    setText(this.words, {
      report: "One page comes here, to save and print. The complete account becomes a file beside the recording's other results; any browser prints it, or makes a PDF of it.",
      export: "Writes a file beside the recording's other results; the recording stays as it is.",
      select: "Makes a recording of a part, sample for sample the same; this one stays as it is.",
      reduce: reduceWords(recording, factors.length > 0),
      transfer: transferTo === "" ? "No disk for copies is known. On the machine that records, start rb-recordings with --transfer-to FOLDER to allow it."
        : `Copies it to ${transferTo} and reads the copy back. Interrupted, it goes on where it was; the disk may be unplugged at any time.`,
    }[this.form]);
    return this.form === "transfer" ? transferTo !== "" : this.form !== "reduce" || factors.length > 0;
  }

  /** As host/recordings/job_order.hpp has them; each with a slash before it. */
  options(): string {
    const times = [["from", this.from.value], ["from-mark", this.fromMark.value], ["to", this.to.value], ["to-mark", this.toMark.value]] as const;
    const names = this.channels.value.split(",").map((name) => name.trim()).filter((name) => name !== "").join(",");
    const all: Readonly<Record<JobForm, readonly (readonly [string, string])[]>> = {
      report: [["before", this.before.element.value], ["complete", this.extent.element.value]],
      export: [["format", this.format.element.value], ...times.filter(([key]) => !key.endsWith("mark")), ["channels", names]],
      select: [...times, ["channels", names]],
      reduce: [["rate", this.rate.element.value]],
      transfer: [],
    };
    return all[this.form].filter(([, value]) => value !== "").map(([key, value]) => `/${key}=${value}`).join("");
  }
}
