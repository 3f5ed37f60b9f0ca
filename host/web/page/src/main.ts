// The page: its parts, and the way of messages to them.
import {Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import {Asker} from "./ask";
import {connectFeed} from "./feed";
import {DriverView} from "./driver_view";
import {EquipmentView} from "./equipment_view";
import {HeaderView} from "./header_view";
import {HelpView} from "./help_view";
import {listenToKeys, type Key} from "./keys";
import {LampView} from "./lamp_view";
import {LevelView} from "./level_view";
import {OperationView} from "./operation_view";
import {PlotView} from "./plot_view";
import {ReceiptView} from "./receipt_view";
import {RecordingsView} from "./recordings_view";
import {SetupView} from "./setup_view";
import type {Connection} from "./state";
import {startTheme, toggleTheme} from "./theme";
import {toggleUnits, unitsName} from "./units";
import {Views} from "./view";
import {kWheelNames} from "./wheel_place";
import {WheelView} from "./wheel_view";

startTheme();

/** Silence shows, too: so often at least. */
const kRedrawMs = 500;

function start(): void {
  const car = new Car();
  let connection: Connection = "never";
  let dirty = true;
  let drawn = 0;

  const soon = () => {
    header.name(car, connection, performance.now());
    if (!dirty) requestAnimationFrame(draw);
    dirty = true;
  };
  const asker = new Asker(car, soon);
  const operation = new OperationView(car, asker);
  const receiptView = new ReceiptView(car);
  const lampView = new LampView(car);
  const levelView = new LevelView(car);
  const balance = new WheelView(car);
  const views: Views = new Views([
    balance,
    new PlotView(car),
    new DriverView(car, () => connection, () => views.back()),
    new SetupView(car),
    new EquipmentView(car, asker),
    new RecordingsView(car, asker),
    new HelpView(() => keys().filter(({key}) => key !== "Escape"), () => views.back()),
  ], levelView.element);
  const keys = (): Key[] => [
    ...operation.keys,
    ...views.keys().map((key) => (key.key === "?" && views.isShown("help") ? {...key, run: () => views.back()} : key)),
    ...kWheelNames.map((name, wheel): Key => ({key: String(wheel + 1), does: `${name} wheel`, run: () => {
      views.show(balance.id);
      balance.focus(wheel);
    }})),
    {key: "U", does: "grams or ounces, km/h or mph", run: () => {
      toggleUnits();
      setText(units, `${unitsName()} (U)`);
      soon();
    }},
    {key: "N", does: "day or night", run: toggleTheme},
    {key: "A", does: "acknowledge the lamps", run: () => lampView.acknowledge()},
  ];
  const button = (text: string, key: string) => {
    const made = el("button", {type: "button"}, [text]);
    made.onclick = () => keys().find((candidate) => candidate.key === key)?.run();
    return made;
  };
  const units = button(`${unitsName()} (U)`, "U");
  const header = new HeaderView([button("Acknowledge (A)", "A"), button("Day/night (N)", "N")], operation.element);
  const rate = el("footer", {id: "rate"});
  document.body.append(header.element, lampView.element, receiptView.element, el("div", {class: "tab-bar"}, [
    views.tabs, el("div", {class: "buttons"}, [button("Driver (D)", "D"), units])]), views.panels, rate);
  views.begin();
  listenToKeys(keys);

  const draw = () => {
    dirty = false;
    const nowMs = performance.now();
    header.draw(car, connection, nowMs);
    operation.draw(connection, nowMs);
    receiptView.draw(nowMs);
    lampView.draw(nowMs);
    if (!levelView.element.hidden) levelView.draw(nowMs);
    views.draw(nowMs);
    setAttributes(document.body, {"data-connected": String(connection === "open"), "data-drawn": ++drawn});
  };
  let framesAtLastCount = 0, frames = 0;
  setInterval(() => {
    setText(rate, connection === "open" ? `${frames - framesAtLastCount} updates/s` : "no updates");
    framesAtLastCount = frames;
  }, 1000);
  setInterval(soon, kRedrawMs);
  connectFeed(car.plots.viewer, {
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
