// Which recordings there are, and what proves that they are whole.  They are not to be deleted from here.
import type {Car} from "./car";
import {el, setAttributes, setLines, setRows, setText, svg, table} from "./dom";
import {untilZero, utf8} from "./text";
import type {View} from "./view";
import {RecordingState, type Recording} from "./wire";
import {duration} from "./words";

const kRedrawMs = 500;
/** rb-recordings says all of them once a second, if the computer has time for it. */
const kOldMs = 10_000;

const kWords: Readonly<Record<RecordingState, readonly [tone: string, word: string, shape: string]>> = {
  [RecordingState.NotRead]: ["quiet", "being checked", "M2 7h12v2h-12z"],
  [RecordingState.Growing]: ["good", "being written", "M8 2a6 6 0 1 0 0 12a6 6 0 1 0 0-12z"],
  [RecordingState.Complete]: ["good", "COMPLETE", "M2 9l4 4l8-9l-2-2l-6 7l-2-2z"],
  [RecordingState.Incomplete]: ["warn", "INCOMPLETE", "M8 1l7 13h-14z"],
  [RecordingState.Damaged]: ["bad", "DAMAGED", "M3 1l5 5l5-5l2 2l-5 5l5 5l-2 2l-5-5l-5 5l-2-2l5-5l-5-5z"],
  [RecordingState.Unreadable]: ["bad", "UNREADABLE", "M3 1l5 5l5-5l2 2l-5 5l5 5l-2 2l-5-5l-5 5l-2-2l5-5l-5-5z"],
};

const kGrew = ["quiet", "was being written", "M2 7h12v2h-12z"] as const;

/** As ISO 8601 writes it, of this browser's own time zone. */
const localTime = (time_us: number) => new Date(time_us / 1000).toLocaleString("sv-SE");
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
  readonly element = el("article", {class: "recording"}, [
    el("div", {class: "head"}, [svg("svg", {viewBox: "0 0 16 16", "aria-hidden": "true"}, [this.shape]), this.name, this.word]),
    this.facts, this.verdict, this.table, this.marks]);

  /** @param isOld  nobody says it any more */
  draw(recording: Recording, isOld: boolean): void {
    const grew = isOld && recording.state === RecordingState.Growing;
    const [tone, word, shape] = grew ? kGrew : kWords[recording.state as RecordingState];
    setAttributes(this.element, {"data-tone": tone});
    setAttributes(this.shape, {d: shape});
    setText(this.name, untilZero(recording.name));
    setText(this.word, word);
    const length = duration(Math.max(0, recording.last_us - recording.first_us) / 1e6);
    const about = [untilZero(recording.vehicle), ...(recording.first_us > 0 ? [localTime(recording.first_us), length] : []),
                   `${(recording.bytes / 1e9).toFixed(2)} GB`];
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
        {text: String(lost), tone: lost > 0 ? "bad" : "good"}, {text: String(recording.repaired[k])},
        {text: duration(recording.seconds[k] ?? 0)}, {text: `${overload.toFixed(1)} s`, tone: overload > 0 ? "warn" : ""},
        {text: sync < 0 ? "not known" : `${Math.ceil(1e6 * sync)} µs`}];
    }));
    const shown = Math.min(recording.marks, recording.mark.length);
    setLines(this.marks, [
      ...Array.from({length: shown}, (_, k) => `Mark ${localTime(recording.mark_us[k] ?? 0)}: ${untilZero(recording.mark[k] ?? []) || "–"}`),
      ...(recording.marks > shown ? [`and ${recording.marks - shown} more`] : [])]);
  }
}

export class RecordingsView implements View {
  readonly id = "recordings";
  readonly title = "Recordings";
  readonly key = "L";
  readonly does = "list of recordings and their receipts";
  readonly withLevels = false;
  readonly element: HTMLElement;
  private readonly none = el("p", {}, ["None is known: start rb-recordings beside the recorder, with the folder that holds them."]);
  private readonly old = el("p", {class: "old", role: "status"});
  private readonly list = el("div", {class: "list"});
  private readonly cards: RecordingCard[] = [];
  private drawnMs = -Infinity;

  constructor(private readonly car: Car) {
    this.element = el("section", {class: "recordings"}, [el("h2", {}, ["Recordings"]), this.none, this.old, this.list]);
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
    while (this.cards.length > known.length) this.cards.pop()?.element.remove();
    known.forEach((recording, k) => {
      let card = this.cards[k];
      if (!card) {
        this.cards.push(card = new RecordingCard());
        this.list.append(card.element);
      }
      card.draw(recording, isOld);
    });
  }
}
