// Fields to choose the content of a plot.
import {channelKey, channelName, channelOfKey, type ChannelId} from "./channels";
import type {Car} from "./car";
import {el, setAttributes, setText} from "./dom";

/** A field with a few choices. */
export class Choice<T extends string> {
  readonly element: HTMLElement;
  private readonly select = el("select");
  private offered = "";

  constructor(id: string, label: string, options: Readonly<Record<T, string>>, now: T, private readonly changed: () => void) {
    this.select.id = id;
    this.element = el("label", {class: "choice"}, [el("span", {}, [label]), this.select]);
    this.offer(options);
    this.select.value = now;
    // After a choice by hand keys belong to the plot again; after a choice by key the focus stays.
    let byHand = false;
    this.select.onpointerdown = () => { byHand = true; };
    this.select.onkeydown = () => { byHand = false; };
    this.select.onchange = () => {
      this.changed();
      if (byHand) this.select.blur();
    };
  }

  get value(): T {
    return this.select.value as T;
  }

  set value(value: T) {
    this.select.value = value;
  }

  /** What can be chosen from now on; what was chosen stays if it is among it. */
  offer(options: Readonly<Record<string, string>>): void {
    const offered = JSON.stringify(options);
    if (offered === this.offered) return;
    this.offered = offered;
    const now = this.select.value;
    this.select.replaceChildren(...Object.entries(options).map(([value, text]) => el("option", {value}, [text])));
    if (now in options) this.select.value = now;
  }
}

/** A field with one channel of those that there are. */
export class ChannelChoice {
  private readonly choice: Choice<string>;
  private touched = false;

  constructor(id: string, label: string, changed: () => void) {
    this.choice = new Choice<string>(id, label, {}, "", () => {
      this.touched = true;
      changed();
    });
  }

  get element(): HTMLElement {
    return this.choice.element;
  }

  get value(): ChannelId | undefined {
    return channelOfKey(this.choice.value);
  }

  /** @param usual  what is chosen as long as nobody has chosen */
  offer(car: Car, channels: readonly ChannelId[], usual: ChannelId | undefined): void {
    this.choice.offer(Object.fromEntries(channels.map((id) => [channelKey(id) , label(car, id)])));
    if (!this.touched && usual) this.choice.value = channelKey(usual);
  }
}

const label = (car: Car, id: ChannelId) => {
  const name = channelName(car, id);
  return name === channelKey(id) ? `channel ${name}` : name;
};

/** Any of the channels, up to some number of them. */
export class ChannelsChoice {
  readonly element: HTMLElement;
  private readonly summary = el("summary");
  private readonly buttons = el("div", {class: "chips"});
  private readonly chosen = new Set<string>();
  private touched = false;
  private offered = "";

  constructor(id: string, private readonly most: number, private readonly changed: () => void) {
    this.element = el("details", {class: "channels-choice", id}, [this.summary, this.buttons]);
  }

  get value(): ChannelId[] {
    return [...this.chosen].flatMap((key) => channelOfKey(key) ?? []);
  }

  /** @param usual  what is chosen as long as nobody has chosen */
  offer(car: Car, channels: readonly ChannelId[], usual: readonly ChannelId[]): void {
    if (!this.touched) {
      this.chosen.clear();
      for (const id of usual.slice(0, this.most)) this.chosen.add(channelKey(id));
    }
    const offered = JSON.stringify(channels.map((id) => [channelKey(id), label(car, id)]));
    if (offered !== this.offered) {
      this.offered = offered;
      this.buttons.replaceChildren(...channels.map((id) => this.button(car, id)));
    }
    for (const button of this.buttons.children)
      setAttributes(button, {"aria-pressed": String(this.chosen.has((button as HTMLElement).dataset["key"] ?? ""))});
    setText(this.summary, `Channels: ${this.value.map((id) => label(car, id)).join(", ") || "none"}`);
  }

  private button(car: Car, id: ChannelId): HTMLElement {
    const key = channelKey(id);
    const button = el("button", {type: "button", class: "chip", "data-key": key}, [label(car, id)]);
    button.onclick = () => {
      this.touched = true;
      if (!this.chosen.delete(key) && this.chosen.size < this.most) this.chosen.add(key);
      this.changed();
    };
    return button;
  }
}
