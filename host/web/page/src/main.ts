// The page: its parts, and how news get to them.
import {Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import {connectFeed} from "./feed";
import {HeaderView} from "./header_view";
import {listenToKeys, type Key} from "./keys";
import {LampView} from "./lamp_view";
import {LevelView} from "./level_view";
import type {Connection} from "./state";
import {startTheme, toggleTheme} from "./theme";
import {WheelView} from "./wheel_view";

startTheme();

/** Silence shows, too: so often at least. */
const kRedrawMs = 500;

function helpDialog(keys: readonly Key[]): HTMLDialogElement {
  const close = el("button", {type: "button"}, ["Close (Esc)"]);
  const dialog = el("dialog", {id: "help", "aria-label": "Help"}, [
    el("h2", {}, ["Keys"]),
    el("dl", {}, keys.flatMap(({key, does}) => [el("dt", {}, [el("kbd", {}, [key])]), el("dd", {}, [does])])),
    el("p", {}, ["An angle counts from the wheel's zero mark in the direction of rotation. With the mark at 12 the clock " +
                 "says where that is, seen from outside the car: a left wheel turns counter-clockwise, a right one clockwise."]),
    el("p", {}, ["± is one standard deviation; the ellipse holds the unbalance with 95 %. A lamp stays lit until it is " +
                 "acknowledged (A). This page records nothing and can lose nothing: close it whenever you like."]),
    close]);
  close.onclick = () => dialog.close();
  return dialog;
}

function start(): void {
  const car = new Car();
  let connection: Connection = "never";
  let dirty = true;
  let drawn = 0;

  const lampView = new LampView(car);
  const levelView = new LevelView(car);
  const wheelView = new WheelView(car);
  const wheelKey = (wheel: number, name: string): Key =>
    ({key: String(wheel + 1), does: name, run: () => wheelView.show(wheel)});
  const keys: Key[] = [
    {key: "N", does: "day or night", run: toggleTheme},
    ...["front left wheel", "front right wheel", "rear left wheel", "rear right wheel"].map((name, k) => wheelKey(k, name)),
    {key: "A", does: "acknowledge the lamps", run: () => lampView.acknowledge()},
    {key: "?", does: "this help", run: () => (help.open ? help.close() : help.showModal())},
  ];
  const help = helpDialog(keys);
  const button = (text: string, key: string) => {
    const made = el("button", {type: "button"}, [text]);
    made.onclick = () => keys.find((candidate) => candidate.key === key)?.run();
    return made;
  };
  const header = new HeaderView([button("Acknowledge (A)", "A"), button("Day/night (N)", "N"), button("Help (?)", "?")]);
  const rate = el("footer", {id: "rate"});
  document.body.append(header.element, lampView.element, el("main", {}, [wheelView.element, levelView.element]), rate, help);
  listenToKeys(keys);

  const draw = () => {
    dirty = false;
    const nowMs = performance.now();
    header.draw(car, connection, nowMs);
    lampView.draw(nowMs);
    levelView.draw(nowMs);
    wheelView.draw();
    setAttributes(document.body, {"data-connected": String(connection === "open"), "data-drawn": ++drawn});
  };
  const soon = () => {
    if (!dirty) requestAnimationFrame(draw);
    dirty = true;
  };
  let framesAtLastCount = 0, frames = 0;
  setInterval(() => {
    setText(rate, connection === "open" ? `${frames - framesAtLastCount} updates/s` : "no updates");
    framesAtLastCount = frames;
  }, 1000);
  setInterval(soon, kRedrawMs);
  connectFeed({
    frame(frame) {
      ++frames;
      try {
        car.take(frame, performance.now());
      } catch {
        ++car.strangers;
      }
      soon();
    },
    connected(is) {
      if (is) connection = "open";
      else if (connection === "open") connection = "lost";
      soon();
    },
  });
  draw();
}

document.addEventListener("DOMContentLoaded", start);
