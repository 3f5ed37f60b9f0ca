// Help for a person who has never seen this page.
import type {Key} from "./keys";
import {el} from "./dom";
import type {View} from "./view";

const kFirstDay: readonly string[] = [
  "Mark a point of each wheel, the valve for one: all angles count from there.",
  "Switch on nodes and recorder. Set-up (S) lists what is heard; every line of the check should say OK, once the wheels have rolled and each sensor was knocked on.",
  "Tap test: knock on each sensor as the table says, on both sides. A wrong sign is mended now, not after the drive.",
  "Tell each wheel where its valve is when its zero mark fires: Equipment (E) leads you through turning it by hand, and sets scales and zeros of channels.",
  "Roll a few metres: the encoders' lines of the check become OK.",
  "Start the recording. The word on top is RECORDING, and the four lamps are discs: SYNC after a while, for clocks are asked only now.",
  "Drive steadily at 80 to 130 km/h, straight, on a good road; now and then change lanes or take a bend.",
  "Look at Balance (B), or give the driver his own view (D): each ring fills as its wheel becomes known.",
  "When the rings are full stop, put the weights where the page says, seen from outside, and write them into vehicle.toml.",
  "Drive once more: the page puts this drive beside the one before, and tells what the weights have done.",
  "When it is stopped, Recordings (L) proves a recording complete, works its balance out anew, and makes a report of one A4 page, beside the drive before if you choose it.",
];
const kLamps: readonly (readonly [name: string, means: string])[] = [
  ["LOSS", "Disc: every sample is recorded, or on its way. Cross: a device is gone, or samples are lost for good; which ones is in the record."],
  ["SYNC", "How well the clock of the worst node is known. Triangle: worse than 50 µs, or not heard. Cross: a clock has jumped."],
  ["OVERLOAD", "Cross: a channel has left its range, or is clipped below it (CLIP: its tops are cut off at one value); its reading is wrong there. Choose a larger range. Triangle: a channel is dead, or its mean is where none can be (DC)."],
  ["ENCODER", "Cross: turns with teeth missed or extra. Look at the gap of the sensor and at its cable."],
  ["All four", "A line means not known. A lit lamp stays lit until it is acknowledged (A), though the cause be gone."],
];

export class HelpView implements View {
  readonly id = "help";
  readonly title = "Help";
  readonly key = "?";
  readonly does = "this help, and back";
  readonly keys: readonly Key[];
  readonly element: HTMLElement;
  private readonly list = el("dl", {class: "keys"});

  /** @param all  every key there is, asked when the help is seen */
  constructor(private readonly all: () => readonly Key[], back: () => void) {
    this.keys = [{key: "Escape", does: "back from this help", run: back}];
    this.element = el("section", {class: "help"}, [
      el("h2", {}, ["The first day in a car"]),
      el("ol", {}, kFirstDay.map((line) => el("li", {}, [line]))),
      el("h2", {}, ["Keys"]), this.list,
      el("h2", {}, ["The four lamps"]),
      el("dl", {}, kLamps.flatMap(([name, means]) => [el("dt", {}, [el("strong", {}, [name])]), el("dd", {}, [means])])),
      el("h2", {}, ["Angles and uncertainty"]),
      el("p", {}, ["An angle counts from the wheel's reference point (the valve) in the direction of rotation. With the valve at 12 the clock " +
                   "says where that is, seen from outside the car: a left wheel turns counter-clockwise, a right one clockwise."]),
      el("p", {}, ["± is one standard deviation; the ellipse holds the unbalance with 95 %. The ring of a wheel is full when ± is " +
                   "as small as [limits] sigma_g in vehicle.toml wants it: that decides, not the time driven."]),
      el("p", {}, ["A weight marked hollow sits behind the wheel, on the side of the car. Which side takes a weight is the order of " +
                   "[[wheel.place]] in vehicle.toml: vertical accelerations tell the static unbalance, not the couple of two masses " +
                   "opposite to one another on both sides of a wheel. List first the place nearest to the middle of the rim, or put " +
                   "half of the mass on either flange at the same angle: that adds no couple."]),
      el("p", {}, ["A polar plot shows X of x = Re{X e^(jhα)}: x is the acceleration, α the wheel's angle from its reference point in the " +
                   "direction of rotation, h the order."]),
      el("p", {}, ["What is recorded does not pass through this page: close it whenever you like."])]);
  }

  seen(is: boolean): void {
    if (!is) return;
    this.list.replaceChildren(...this.all().flatMap(({key, does}) =>
      [el("dt", {}, [el("kbd", {}, [key === " " ? "Space" : key])]), el("dd", {}, [does])]));
  }

  draw(): void {
    // The help does not change while it is shown.
  }
}
