// The share of the needed driving that is done, as a circle.
import {setAttributes, setText, svg} from "./dom";
import type {Progress} from "./words";

const kRadius = 20;
const kLength = 2 * Math.PI * kRadius;

export class ProgressRing {
  private readonly done = svg("circle", {class: "done", r: kRadius, "stroke-dasharray": `0 ${kLength}`, transform: "rotate(-90)"});
  private readonly number = svg("text", {y: 5});
  readonly element = svg("svg", {class: "ring", viewBox: "-25 -25 50 50", "aria-hidden": "true"}, [
    svg("circle", {class: "all", r: kRadius}), this.done, this.number]);

  draw({share, isDone}: Progress, isGood = true): void {
    setAttributes(this.element, {"data-done": isDone && !isGood ? "bad" : String(isDone)});
    setAttributes(this.done, {"stroke-dasharray": `${(share * kLength).toFixed(1)} ${kLength.toFixed(1)}`});
    setText(this.number, isDone ? (isGood ? "✓" : "✗") : `${Math.floor(100 * share)}%`);
  }
}
