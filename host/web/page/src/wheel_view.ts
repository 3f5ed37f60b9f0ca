// Balance: four wheels, what is on them and what to do.
import type {Car} from "./car";
import {el, setAttributes, setLines, setText} from "./dom";
import type {View} from "./view";
import {fullScale, WheelDrawing} from "./wheel_drawing";
import {kWheelNames} from "./wheel_place";
import {Unknown, type Balance, type Compensation} from "./wire";
import {basis, heavySpot, whatIsLeft, whatToDo, whyIncurable} from "./words";

class WheelCard {
  readonly element: HTMLElement;
  private readonly drawing: WheelDrawing;
  private readonly spot = el("p", {class: "spot-sentence"});
  private readonly steps = el("div", {class: "steps"});
  private readonly left = el("p", {class: "left"});
  private readonly incurable = el("p", {class: "incurable"});
  private drawn: {balance?: Balance | undefined; plan?: Compensation | undefined; rim_g?: number} = {};

  constructor(private readonly wheel: number, name: string) {
    this.drawing = new WheelDrawing(wheel);
    this.element = el("article", {class: "card", id: `wheel-${wheel + 1}`, tabindex: "0", "aria-label": name}, [
      this.drawing.element,
      el("div", {class: "text"}, [el("h3", {}, [name]), this.incurable, this.steps, this.spot, this.left])]);
  }

  draw(car: Car, rim_g: number): void {
    const balance = car.balance.get(this.wheel)?.message;
    const plan = car.advice(this.wheel);
    if (balance && balance === this.drawn.balance && plan === this.drawn.plan && rim_g === this.drawn.rim_g) return;
    this.drawn = {balance, plan, rim_g};
    setAttributes(this.element, {"data-known": String(balance?.state === Unknown.None)});
    this.drawing.draw(balance, plan, rim_g);
    setLines(this.steps, whatToDo(plan));
    setText(this.spot, heavySpot(balance));
    setText(this.left, whatIsLeft(plan));
    const why = whyIncurable(plan);
    setText(this.incurable, why ? `WEIGHTS WILL NOT CURE THIS: ${why}.` : "");
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

  constructor(private readonly car: Car) {
    this.element = el("section", {class: "balance"}, [
      el("h2", {}, ["Balance ", this.basis]),
      el("div", {class: "cards"}, this.cards.map(({element}) => element)),
      el("p", {class: "legend"}, [
        "Each wheel as seen from outside the car, its zero mark (▼) at 12. ",
        el("span", {class: "key spot-key"}, ["● heavy spot"]), " ", el("span", {class: "key weight-key"}, ["■ weight"]), " ",
        el("span", {class: "key vector-key"}, ["― unbalance and where it is with 95 %"])])]);
  }

  focus(wheel: number): void {
    const card = this.cards[wheel]?.element;
    card?.focus();
    card?.scrollIntoView({block: "nearest"});
  }

  draw(): void {
    setText(this.basis, basis(this.car.identification?.message));
    const scale = fullScale([...this.car.balance.values()].map(({message}) => message));
    for (const card of this.cards) card.draw(this.car, scale);
  }
}
