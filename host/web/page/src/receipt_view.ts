// The receipts of the nodes for the recording that was stopped last: what is on the disk.
import {isBusy, type Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import {utf8} from "./text";
import type {Receipt} from "./wire";
import {duration} from "./words";

const kColumns = ["Node", "Samples", "Lost", "Repaired", "Overload", "Clock within", "CRC-32C"];

// The verdict of receipt_t on the CRCs of the ends; the third state is unknown.
const kContradict = 0, kAgree = 1;

const lost = (receipt: Receipt) => receipt.samples_sent - receipt.samples_recorded;
/** When the node did not measure or was not heard, and why; empty: it measured from start to stop. */
const missing = (receipt: Receipt) => [utf8(receipt.absence, receipt.absence_size), utf8(receipt.unheard, receipt.unheard_size)]
  .filter((text) => text !== "").join("; ");
const lacksNothing = (receipt: Receipt) => lost(receipt) === 0 && receipt.gaps === 0 && receipt.open_epochs === 0 &&
  missing(receipt) === "";
const isWhole = (receipt: Receipt) => lacksNothing(receipt) && receipt.end_sums === kAgree;

/** What is not as it should be, in one line. */
export function defects(receipts: readonly Receipt[]): string {
  const sum = (of: (receipt: Receipt) => number) => receipts.reduce((all, receipt) => all + of(receipt), 0);
  const [gone, gaps, open] = [sum(lost), sum((receipt) => receipt.gaps), sum((receipt) => receipt.open_epochs)];
  const wrong = receipts.filter(({end_sums}) => end_sums === kContradict);
  const unproven = receipts.filter((receipt) => lacksNothing(receipt) && !isWhole(receipt) && !wrong.includes(receipt));
  const nodes = (of: readonly Receipt[]) => of.map(({node}) => node).join(", ");
  return [
    ...receipts.filter((receipt) => missing(receipt) !== "").map((receipt) => `node ${receipt.node} ${missing(receipt)}`),
    ...(gone > 0 ? [`${gone.toLocaleString("en")} lost`] : []),
    ...(gaps > 0 ? [gaps === 1 ? "1 gap" : `${gaps} gaps`] : []),
    ...(open > 0 ? ["its end is missing"] : []),
    ...(wrong.length > 0 ? [`CRC of node ${nodes(wrong)} DOES NOT AGREE`] : []),
    ...(unproven.length > 0 ? [`CRC of node ${nodes(unproven)} is not known`] : [])].join(", ");
}

function row(receipt: Receipt): HTMLTableRowElement {
  const crc = (receipt.blocks_crc32c >>> 0).toString(16).padStart(8, "0");
  const cells = [
    String(receipt.node), receipt.samples_recorded.toLocaleString("en"),
    missing(receipt) !== "" ? "was absent" : lost(receipt).toLocaleString("en"),
    receipt.repaired.toLocaleString("en"), `${receipt.overload_s.toFixed(1)} s`,
    receipt.sync_us < 0 ? "not known" : `${Math.ceil(receipt.sync_us)} µs`,
    receipt.epochs === 0 ? "nothing" : receipt.end_sums === kContradict ? `${crc} DOES NOT AGREE` : receipt.open_epochs > 0 ? "no end" :
      receipt.end_sums === kAgree ? `${crc} agrees` : "not known"];
  return el("tr", {"data-whole": String(isWhole(receipt))},
            cells.map((cell, k) => (k === 0 ? el("th", {scope: "row"}, [cell]) : el("td", {}, [cell]))));
}

export class ReceiptView {
  readonly element: HTMLElement;
  private readonly title = el("h2", {id: "receipt-title"});
  private readonly facts = el("p");
  private readonly rows = el("tbody");
  private readonly close = el("button", {type: "button"}, ["Close"]);
  private shown = "";
  private closed = 0;

  constructor(private readonly car: Car) {
    const head = el("thead", {}, [el("tr", {}, kColumns.map((column) => el("th", {scope: "col"}, [column])))]);
    this.element = el("section", {class: "receipt", id: "receipt", "aria-labelledby": "receipt-title", hidden: ""}, [
      el("div", {class: "receipt-head"}, [el("div", {}, [this.title, this.facts]), this.close]),
      el("div", {class: "scroll", tabindex: "0"}, [el("table", {}, [head, this.rows])])]);
    this.close.onclick = () => {
      this.closed = this.receipts()[0]?.ended_us ?? 0;
    };
  }

  draw(nowMs: number): void {
    const receipts = this.receipts();
    const [first] = receipts;
    const records = this.car.livingRecorders(nowMs).some(isBusy);
    const isShown = first !== undefined && !records && first.ended_us !== this.closed && receipts.length >= first.nodes;
    this.element.hidden = !isShown;
    if (!isShown) return;
    const what = `${first.called} ${first.ended_us}`;
    if (what === this.shown) return;
    this.shown = what;
    const all = receipts.filter(({nodes}) => nodes > 0);
    const whole = all.length > 0 && all.every(isWhole);
    setAttributes(this.element, {"data-whole": String(whole)});
    setText(this.title, all.length === 0 ? `“${first.called}”: no node was recorded`
      : whole ? `“${first.called}” is on the disk: 0 lost` : `“${first.called}” is NOT WHOLE: ${defects(all)}`);
    const marks = first.marks === 1 ? "1 mark" : `${first.marks} marks`;
    const by = utf8(first.stopped_by, first.stopped_by_size);
    setText(this.facts, `${duration((first.ended_us - first.began_us) / 1e6)} · ${(first.bytes / 1e6).toFixed(1)} MB · ${marks}` +
      (by && ` · stopped by ${by}`) +
      (whole || all.length === 0 ? "" : ". What is missing is declared in the record: rb verify lists it."));
    this.rows.replaceChildren(...all.map(row));
  }

  private receipts(): (Receipt & {readonly called: string})[] {
    return [...this.car.receipts.values()].map(({message}) => message).sort((a, b) => a.index - b.index)
      .map((receipt) => ({...receipt, called: utf8(receipt.name, receipt.name_size)}));
  }
}
