// Balance: four wheels, their weights, the next step, and the effect.
import {isFresh, type Car} from "./car";
import {el, setAttributes, setLines, setText} from "./dom";
import {ProgressRing} from "./progress_ring";
import {untilZero} from "./text";
import {unitSystem} from "./units";
import type {View} from "./view";
import {fullScale, WheelDrawing} from "./wheel_drawing";
import {kWheelNames} from "./wheel_place";
import {Advice, NodeState, Unknown, WeightCheckVerdict} from "./wire";
import {basis, duration, heavySpot, progress, remarks, weightCheckLines, whatIsLeft, whatToDo, whyIncurable, type Step} from "./words";

/** Sentences with a quiet second line. */
function setSteps(element: Element, steps: readonly Step[]): void {
  const wanted = steps.map(({text, detail}) => `${text}|${detail}`).join("|");
  if (element.getAttribute("data-steps") === wanted) return;
  element.setAttribute("data-steps", wanted);
  element.replaceChildren(...steps.map(({text, detail}) =>
    el("p", {}, [`${text}.`, ...(detail ? [" ", el("small", {}, [detail])] : [])])));
}

const isDriven = (car: Car, nowMs: number) =>
  [...car.heartbeats.values()].some((heard) => isFresh(heard, nowMs) && heard.message.state === NodeState.Started);

class WheelCard {
  readonly element: HTMLElement;
  private readonly drawing: WheelDrawing;
  private readonly ring = new ProgressRing();
  private readonly towards = el("span", {class: "towards"});
  private readonly age = el("p", {class: "age"});
  private readonly spot = el("p", {class: "spot-sentence"});
  private readonly steps = el("div", {class: "steps"});
  private readonly left = el("p", {class: "left"});
  private readonly incurable = el("p", {class: "incurable"});
  private readonly weightCheck = el("div", {class: "weight-check"});
  private drawn: readonly unknown[] = [];

  constructor(private readonly wheel: number, name: string) {
    this.drawing = new WheelDrawing(wheel);
    this.element = el("article", {class: "card", id: `wheel-${wheel + 1}`, tabindex: "0", "aria-label": name}, [
      this.drawing.element,
      el("div", {class: "text"}, [
        el("div", {class: "head"}, [this.ring.element, el("div", {}, [el("h3", {}, [name]), this.towards])]),
        this.age, this.incurable, this.steps, this.spot]),
      el("div", {class: "more"}, [this.weightCheck, this.left])]);
  }

  draw(car: Car, rim_g: number, nowMs: number): void {
    const heard = car.balance.get(this.wheel);
    const balance = heard?.message;
    // After the drive a result stands; during it the analyser must repeat it.
    const isOld = heard !== undefined && !isFresh(heard, nowMs) && isDriven(car, nowMs);
    setAttributes(this.element, {"data-old": String(isOld)});
    setText(this.age, isOld ? `OLD: from ${duration((nowMs - heard.atMs) / 1000)} ago` : "");
    const identification = car.identification?.message;
    const plan = car.advice(this.wheel);
    const check = car.weightCheckOf(this.wheel);
    const wanted = [balance, plan, check, identification, rim_g, unitSystem()];
    if (balance && wanted.every((one, k) => one === this.drawn[k])) return;
    this.drawn = wanted;
    setAttributes(this.element, {"data-known": String(balance?.state === Unknown.None)});
    this.drawing.draw(balance, plan, rim_g, check);
    const how = progress(balance, plan, identification);
    this.ring.draw(how);
    setText(this.towards, how.text);
    setSteps(this.steps, whatToDo(plan));
    setText(this.spot, heavySpot(balance, identification));
    setText(this.left, whatIsLeft(plan, balance));
    const why = whyIncurable(plan);
    setText(this.incurable, !why ? ""
      : `WEIGHTS WILL NOT CURE THIS: ${why}.${plan?.advice === Advice.Steps ? " The best that weights do:" : ""}`);
    setLines(this.weightCheck, weightCheckLines(check));
    setAttributes(this.weightCheck, {"data-verdict": WeightCheckVerdict[check?.verdict ?? 0] ?? ""});
  }
}

export class WheelView implements View {
  readonly id = "balance";
  readonly title = "Balance";
  readonly key = "B";
  readonly does = "balance of the wheels";
  readonly withLevels = true;
  readonly element: HTMLElement;
  private readonly cards = kWheelNames.map((name, wheel) => new WheelCard(wheel, name));
  private readonly basis = el("small");
  /** What a sheet of paper must say that the screen says elsewhere. */
  private readonly paper = el("div", {class: "paper"});
  private readonly print = el("button", {type: "button", class: "print"}, ["Print this on A4"]);
  private readonly remarks = el("div");
  private readonly beside = el("section", {class: "remarks", id: "remarks"}, [
    el("h2", {}, ["What this rests on"]), this.remarks]);

  constructor(private readonly car: Car) {
    this.print.onclick = () => window.print();
    window.addEventListener("beforeprint", () => this.drawPaper());
    this.element = el("section", {class: "balance"}, [
      this.paper,
      el("h2", {}, ["Balance ", this.basis]),
      el("div", {class: "cards"}, this.cards.map(({element}) => element)),
      el("p", {class: "legend"}, [
        "Each wheel as seen from outside the car, its reference point (▼, the valve) at 12; ahead of the valve is in the direction of rotation. ",
        el("span", {class: "key spot-key"}, ["● heavy spot"]), " ", el("span", {class: "key weight-key"}, ["■ weight"]), " ", el("span", {class: "key weight-key"}, ["□ behind the wheel"]), " ",
        el("span", {class: "key off-key"}, ["■ red dashed: take off"]), " ",
        el("span", {class: "key vector-key"}, ["― unbalance and where it is with 95 %"]), " ",
        el("span", {class: "key before-key"}, ["┄ before the weights"])]),
      this.beside, this.print]);
  }

  /** Of this drive: car, time, and what proves that it is whole so far. */
  private drawPaper(): void {
    const setup = [...this.car.setups.values()][0]?.message;
    const nodes = [...this.car.heartbeats.values()].map(({message}) => message).sort((a, b) => a.node - b.node);
    setLines(this.paper, [
      `Wheel balance: ${setup ? untilZero(setup.vehicle) : "car not known"}`,
      `Printed ${new Date().toLocaleString("sv-SE")} while the drive went on; rb report makes the report of a finished recording.`,
      ...nodes.map((beat) => `Node ${beat.node}: ${beat.scans_sampled} samples, ${beat.scans_missing + beat.scans_refused} lost, ` +
        `${beat.blocks_repaired} blocks repaired.`)]);
  }

  focus(wheel: number): void {
    const card = this.cards[wheel]?.element;
    card?.focus();
    card?.scrollIntoView({block: "nearest"});
  }

  draw(nowMs: number): void {
    setText(this.basis, basis(this.car.identification?.message));
    const scale = fullScale([...this.car.balance.values()].map(({message}) => message),
                            kWheelNames.flatMap((_, wheel) => this.car.weightCheckOf(wheel) ?? []));
    for (const card of this.cards) card.draw(this.car, scale, nowMs);
    const said = remarks(this.car);
    setLines(this.remarks, said);
    this.beside.hidden = said.length === 0;
  }
}
