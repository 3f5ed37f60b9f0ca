// The recordings, and the proof that they are complete.  They cannot be deleted from here.
import type {Asker} from "./ask";
import type {Car} from "./car";
import {el, setAttributes, setLines, setRows, setText, svg, table} from "./dom";
import {JobView} from "./job_view";
import {kCross, kDisc, kLine, kTick, kTriangle} from "./signs";
import {untilZero, utf8} from "./text";
import type {View} from "./view";
import {RecordingState, type Recording} from "./wire";
import {duration, localTime} from "./words";

const kRedrawMs = 500;
/** rb-recordings says all of them once a second, if the computer has time for it. */
const kOldMs = 10_000;

const kWords: Readonly<Record<RecordingState, readonly [tone: string, word: string, shape: string]>> = {
  [RecordingState.NotRead]: ["quiet", "being checked", kLine],
  [RecordingState.Growing]: ["good", "being written", kDisc],
  [RecordingState.Complete]: ["good", "COMPLETE", kTick],
  [RecordingState.Incomplete]: ["warn", "INCOMPLETE", kTriangle],
  [RecordingState.Damaged]: ["bad", "DAMAGED", kCross],
  [RecordingState.Unreadable]: ["bad", "UNREADABLE", kCross],
};

const kGrew = ["quiet", "was being written", kLine] as const;

const isRead = (state: number) => state >= RecordingState.Complete && state <= RecordingState.Damaged;

class RecordingCard {
  private readonly shape = svg("path");
  private readonly name = el("h3");
  private readonly word = el("span", {class: "word"});
  private readonly facts = el("p");
  private readonly verdict = el("p");
  private readonly receipt = el("tbody");
  private readonly table = table("Receipt", ["node", "samples", "lost", "blocks repaired", "time", "overload", "clock off by at most"],
                                 this.receipt);
  private readonly marks = el("div", {class: "marks"});
  private readonly jobs: JobView;
  readonly element: HTMLElement;

  constructor(car: Car, asker: Asker) {
    this.jobs = new JobView(car, asker);
    this.element = el("article", {class: "recording"}, [
      el("div", {class: "head"}, [svg("svg", {viewBox: "0 0 16 16", "aria-hidden": "true"}, [this.shape]), this.name, this.word]),
      this.facts, this.verdict, this.table, this.marks, this.jobs.element]);
  }

  /** @param others  names of finished recordings beside this one
      @param grows   some recording is being written
      @param isOld   nobody says it any more */
  draw(recording: Recording, others: readonly string[], grows: boolean, isOld: boolean, nowMs: number): void {
    const grew = isOld && recording.state === RecordingState.Growing;
    const [tone, word, shape] = grew ? kGrew : kWords[recording.state as RecordingState];
    setAttributes(this.element, {"data-tone": tone});
    setAttributes(this.shape, {d: shape});
    setText(this.name, untilZero(recording.name));
    setText(this.word, word);
    // A drive that was simulated faster than real time lasts longer than its recording took.
    const length = duration(Math.max((recording.last_us - recording.first_us) / 1e6, ...recording.seconds.slice(0, recording.nodes), 0));
    const about = [untilZero(recording.vehicle), ...(recording.first_us > 0 ? [localTime(recording.first_us), length] : []),
                   recording.bytes < 1e8 ? `${(recording.bytes / 1e6).toFixed(1)} MB` : `${(recording.bytes / 1e9).toFixed(2)} GB`,
                   untilZero(recording.place) && `in ${untilZero(recording.place)}`];
    setText(this.facts, about.filter((fact) => fact !== "").join(" · "));
    const crc = isRead(recording.state)
      ? recording.refused + recording.damaged_bytes === 0 ? "Every CRC is right." : `${recording.refused} blocks with a wrong CRC, ${recording.damaged_bytes} damaged bytes.`
      : "";
    const verdict = utf8(recording.verdict, recording.size);
    setText(this.verdict, [verdict && `${verdict.charAt(0).toUpperCase()}${verdict.slice(1)}.`, crc].filter((each) => each !== "").join(" "));
    this.table.hidden = recording.nodes === 0;
    setRows(this.receipt, Array.from({length: recording.nodes}, (_, k) => {
      const [lost = 0, overload = 0, sync = -1] = [recording.samples_lost[k], recording.overload_s[k], recording.sync_residual_s[k]];
      return [
        {text: String(recording.node[k])}, {text: (recording.samples[k] ?? 0).toLocaleString("en").replaceAll(",", "\u202f")},
        recording.absent[k] ? {text: "was absent", tone: "bad"} : {text: String(lost), tone: lost > 0 ? "bad" : "good"}, {text: String(recording.repaired[k])},
        {text: duration(recording.seconds[k] ?? 0)}, {text: `${overload.toFixed(1)} s`, tone: overload > 0 ? "warn" : ""},
        {text: sync < 0 ? "not known" : `${Math.ceil(1e6 * sync)} µs`}];
    }));
    const shown = Math.min(recording.marks, recording.mark.length);
    setLines(this.marks, [
      ...Array.from({length: shown}, (_, k) => `Mark ${localTime(recording.mark_us[k] ?? 0)}: ${untilZero(recording.mark[k] ?? []) || "–"}`),
      ...(recording.marks > shown ? [`and ${recording.marks - shown} more`] : [])]);
    const name = untilZero(recording.name);
    this.jobs.draw(recording, recording.state !== RecordingState.Growing, others.filter((other) => other !== name), !grows && !isOld, nowMs);
  }
}

export class RecordingsView implements View {
  readonly id = "recordings";
  readonly title = "Recordings";
  readonly key = "L";
  readonly does = "list of recordings, their receipts and reports";
  readonly element: HTMLElement;
  private readonly none = el("p", {}, ["None is known: start rb-recordings beside the recorder, with the folder that holds them."]);
  private readonly old = el("p", {class: "old", role: "status"});
  private readonly why = el("p", {id: "recordings-why", role: "status"});
  private readonly list = el("div", {class: "list"});
  private readonly cards = new Map<string, RecordingCard>();
  private drawnMs = -Infinity;

  constructor(private readonly car: Car, private readonly asker: Asker) {
    this.element = el("section", {class: "recordings"}, [el("h2", {}, ["Recordings"]), this.none, this.old, this.why, this.list]);
  }

  seen(): void {
    this.drawnMs = -Infinity;
  }

  draw(nowMs: number): void {
    if (nowMs - this.drawnMs < kRedrawMs) return;
    this.drawnMs = nowMs;
    const count = this.car.recordings.get(0)?.message.recordings ?? 0;
    const known = Array.from({length: count}, (_, k) => this.car.recordings.get(k)?.message)
      .flatMap((recording) => (recording && recording.recordings === count ? [recording] : []));
    this.none.hidden = this.car.recordings.size > 0;
    const silentMs = nowMs - Math.max(...[...this.car.recordings.values()].map(({atMs}) => atMs));
    const isOld = known.length > 0 && silentMs > kOldMs;
    this.old.hidden = !isOld;
    setText(this.old, isOld ? `rb-recordings has been silent for ${duration(silentMs / 1000)}: the list is as it was then.` : "");
    const grows = known.some(({state}) => state === RecordingState.Growing);
    setText(this.why, known.length === 0 || isOld ? "" : !this.asker.mayAsk() ? "To watch only: this page was opened without #token=… of the address that rb-web prints."
      : grows ? "A recording is being written and the disk is its own: proofs and reports when it has stopped." : "");
    const finished = known.filter(({state}) => isRead(state)).map(({name}) => untilZero(name));
    const names = known.map(({name}) => untilZero(name));
    // A changed list comes one recording after the other: until it is complete no card, and no form, gives way.
    if (known.length < count && this.cards.size > 0) return;
    for (const [name, card] of this.cards) {
      if (names.includes(name)) continue;
      card.element.remove();
      this.cards.delete(name);
    }
    // A card stays with its recording when another comes before it: a person may be filling in its form.
    known.forEach((recording, k) => {
      const name = names[k] ?? "";
      const card = this.cards.get(name) ?? new RecordingCard(this.car, this.asker);
      this.cards.set(name, card);
      if (this.list.children[k] !== card.element) this.list.insertBefore(card.element, this.list.children[k] ?? null);
      card.draw(recording, finished, grows, isOld, nowMs);
    });
  }
}
