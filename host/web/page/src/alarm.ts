// Three levels of alarm, by word, shape and colour; common/bus/alarm.hpp has the level of each cause.
import {el, setAttributes, setText, svg} from "./dom";
import {kCross, kDisc, kTriangle} from "./signs";
import {AlarmCause, AlarmLevel} from "./wire";

export const levelOf = (cause: AlarmCause) => Math.floor(cause / 100) as AlarmLevel;
/** As the command line says it. */
export const levelWord = (level: AlarmLevel) => AlarmLevel[level]?.toUpperCase() ?? "";
/** Of a lamp that it lights. */
export const lightOf = (cause: AlarmCause) => (levelOf(cause) === AlarmLevel.Alarm ? "bad" : "warn");

const kShapes: Readonly<Record<number, string>> = {
  [AlarmLevel.Alarm]: kCross, [AlarmLevel.Warning]: kTriangle, [AlarmLevel.Notice]: kDisc};

/** Something to know or to do. */
export interface Saying {
  readonly level: AlarmLevel;
  readonly text: string;
}

export const saying = (cause: AlarmCause, text: string): Saying => ({level: levelOf(cause), text});

/** "▲ WARNING": what a level looks like beside its text. */
export class LevelSign {
  private readonly shape = svg("path");
  private readonly word = el("b");
  readonly element = el("span", {class: "level"}, [
    svg("svg", {viewBox: "0 0 16 16", "aria-hidden": "true"}, [this.shape]), this.word]);

  draw(level: AlarmLevel): void {
    setAttributes(this.element, {"data-level": levelWord(level)});
    setAttributes(this.shape, {d: kShapes[level] ?? kDisc});
    setText(this.word, levelWord(level));
  }
}

export function levelSign(level: AlarmLevel): HTMLElement {
  const sign = new LevelSign();
  sign.draw(level);
  return sign.element;
}

/** Lines of them, each touched only where it changes. */
export class SayingLines {
  readonly element = el("div", {class: "sayings"});
  private readonly lines: {readonly sign: LevelSign; readonly text: HTMLElement; readonly line: HTMLElement}[] = [];

  draw(sayings: readonly Saying[]): void {
    while (this.lines.length > sayings.length) this.lines.pop()?.line.remove();
    while (this.lines.length < sayings.length) {
      const sign = new LevelSign(), text = el("span"), line = el("p", {}, [sign.element, text]);
      this.lines.push({sign, text, line});
      this.element.append(line);
    }
    sayings.forEach(({level, text}, k) => {
      this.lines[k]?.sign.draw(level);
      const line = this.lines[k];
      if (line) setText(line.text, text);
    });
  }
}
