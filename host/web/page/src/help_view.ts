// What a person needs to know who has never seen this page.
import type {Key} from "./keys";
import {el} from "./dom";
import type {View} from "./view";

export class HelpView implements View {
  readonly id = "help";
  readonly title = "Help";
  readonly key = "?";
  readonly does = "this help, and back";
  readonly withLevels = false;
  readonly keys: readonly Key[];
  readonly element: HTMLElement;
  private readonly list = el("dl", {class: "keys"});

  /** @param all  every key there is, asked when the help is seen */
  constructor(private readonly all: () => readonly Key[], back: () => void) {
    this.keys = [{key: "Escape", does: "back from this help", run: back}];
    this.element = el("section", {class: "help"}, [
      el("h2", {}, ["Keys"]), this.list,
      el("h2", {}, ["Angles and uncertainty"]),
      el("p", {}, ["An angle counts from the wheel's zero mark in the direction of rotation. With the mark at 12 the clock " +
                   "says where that is, seen from outside the car: a left wheel turns counter-clockwise, a right one clockwise."]),
      el("p", {}, ["± is one standard deviation; the ellipse holds the unbalance with 95 %. A lamp stays lit until it is " +
                   "acknowledged (A). What is recorded does not pass through this page: close it whenever you like."])]);
  }

  seen(is: boolean): void {
    if (!is) return;
    this.list.replaceChildren(...this.all().flatMap(({key, does}) =>
      [el("dt", {}, [el("kbd", {}, [key === " " ? "Space" : key])]), el("dd", {}, [does])]));
  }

  draw(): void {
    // It does not change while it is seen.
  }
}
