// Range, filter, zeros, scale, zero marks and vehicle file: settings that change between recordings.
import type {Asker} from "./ask";
import {isBusy, type Car} from "./car";
import {el, setAttributes, setText} from "./dom";
import {MarkView} from "./mark_view";
import type {View} from "./view";
import {Operation} from "./wire";

type Settable = Operation.Range | Operation.Filter | Operation.Zero | Operation.Vehicle | Operation.Scale;

function field(id: string, name: string, more: Readonly<Record<string, string>>): {label: HTMLLabelElement; input: HTMLInputElement} {
  const input = el("input", {id, autocomplete: "off", ...more});
  return {label: el("label", {for: id}, [name, input]), input};
}

const number = (min: number, max: number) => ({type: "number", min: String(min), max: String(max), step: "any", required: ""});

/** "2.5" */
function placeOf(text: string): {readonly node: number; readonly channel: number} {
  const [node, channel] = text.split(".").map(Number);
  return {node: node ?? 0, channel: (channel ?? 0) - 1};
}

/** One thing that can be set: a form, and what has become of it. */
class Setting {
  readonly says = el("p", {role: "status"});
  readonly button: HTMLButtonElement;
  readonly element: HTMLElement;

  constructor(readonly operation: Settable, title: string, what: string, doIt: string, fields: readonly HTMLElement[],
              ask: () => void, readonly more: readonly HTMLButtonElement[] = []) {
    this.button = el("button", {type: "submit", id: `set-${Operation[operation].toLowerCase()}`}, [doIt]);
    const form = el("form", {class: "controls"}, [...fields, this.button, ...more]);
    form.onsubmit = (event) => {
      event.preventDefault();
      if (!this.button.disabled) ask();
    };
    this.element = el("section", {class: "setting"}, [el("h2", {}, [title]), el("p", {}, [what]), form, this.says]);
  }
}

export class EquipmentView implements View {
  readonly id = "equipment";
  readonly title = "Equipment";
  readonly key = "E";
  readonly does = "equipment: range, filter, zeros, scale, zero marks, vehicle file";
  readonly element: HTMLElement;
  private readonly channel = field("range-channel", "channel", {type: "text", placeholder: "2.5", required: "",
                                                                pattern: "[0-9]{1,4}[.]([1-9]|1[0-2])",
                                                                title: "node.channel, for example 2.5"});
  private readonly range = field("range-value", "full scale, m/s²", number(0.1, 100_000));
  private readonly turned = field("scale-channel", "channel", {type: "text", placeholder: "2.5", required: "",
                                                               pattern: "[0-9]{1,4}[.]([1-9]|1[0-2])",
                                                               title: "node.channel, for example 2.5"});
  private readonly down = el("button", {type: "button", id: "set-scale-down"}, ["Read: arrow down"]);
  private readonly corner = field("filter-corner", "corner, Hz", number(1, 100_000));
  private readonly order = field("filter-order", "order (empty: as it is)", {type: "number", min: "1", max: "12", step: "1"});
  private readonly vehicle = field("vehicle-name", "file", {type: "text", placeholder: "car.toml", required: "", maxlength: "100"});
  private readonly settings: readonly Setting[];
  private readonly mark: MarkView;
  private readonly why = el("p", {id: "equipment-why", role: "status"});

  constructor(private readonly car: Car, private readonly asker: Asker) {
    this.settings = [
      new Setting(Operation.Range, "Range of a channel",
                  "The least range that the drive does not leave gives the finest counts. Voltage, calibration and zero go with it.",
                  "Set range", [this.channel.label, this.range.label], () => this.setRange()),
      new Setting(Operation.Filter, "Anti-aliasing filter", "Butterworth, the same for all nodes.", "Set filter",
                  [this.corner.label, this.order.label], () => asker.ask(Operation.Filter, {value: [
                    this.corner.input.valueAsNumber, this.order.input.value === "" ? 0 : this.order.input.valueAsNumber]})),
      new Setting(Operation.Zero, "Zeros",
                  "What every acceleration reads now, mean of three seconds, becomes its zero. The car must stand still.",
                  "Zero all channels", [], () => asker.ask(Operation.Zero)),
      new Setting(Operation.Scale, "Scale of a channel by gravity",
                  "Before a sensor is fitted: lay it still with the arrow of its positive direction up, wait three seconds, read; turn it " +
                  "over, wait, read. Both readings together are its scale. Zero all channels when it is fitted.",
                  "Read: arrow up", [this.turned.label], () => this.readScale(1), [this.down]),
      new Setting(Operation.Vehicle, "Vehicle file", "One of those beside the file that the recorder was started with.",
                  "Use file", [this.vehicle.label], () => asker.ask(Operation.Vehicle, {text: this.vehicle.input.value.trim()})),
    ];
    this.mark = new MarkView(asker);
    this.down.onclick = () => { if (this.turned.input.reportValidity()) this.readScale(-1); };
    this.element = el("section", {class: "equipment"}, [this.why, ...this.settings.map(({element}) => element), this.mark.element]);
  }

  draw(nowMs: number): void {
    const recorders = this.car.livingRecorders(nowMs);
    const isRecording = recorders.some(isBusy);
    const noRecorder = recorders.some(({operable}) => operable !== 0) ? ""
      : "No recorder takes requests: run rb-recorder --recordings FOLDER --vehicle FILE.";
    const watching = this.asker.mayAsk() ? "" : "To watch only: this page was opened without #token=… of the address that rb-web prints.";
    const why = watching ||
      (isRecording ? "Not while a recording is under way: it has one set-up from its first sample to its last. Stop it first." : noRecorder);
    setText(this.why, why);
    for (const {operation, button, more, says} of this.settings) {
      for (const each of [button, ...more])
        each.disabled = why !== "" || this.settings.some((setting) => this.asker.isUnderWay(setting.operation, nowMs));
      const {text, isBad} = this.asker.says(operation, nowMs);
      setText(says, text);
      setAttributes(says, {"data-bad": String(isBad), id: `says-${Operation[operation].toLowerCase()}`});
    }
    this.mark.draw(watching || noRecorder || (isRecording ? "" : "To read a zero mark start a recording first (R)."), why, nowMs);
  }

  private setRange(): void {
    this.asker.ask(Operation.Range, {...placeOf(this.channel.input.value), value: [this.range.input.valueAsNumber]});
  }

  /** @param arrow  1 up, -1 down */
  private readScale(arrow: number): void {
    this.asker.ask(Operation.Scale, {...placeOf(this.turned.input.value), value: [arrow]});
  }
}
