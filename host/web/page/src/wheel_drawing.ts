// A wheel seen from beside the car, the reference point on top.
import {setAttributes, setText, svg} from "./dom";
import {weightMass} from "./units";
import {clockwise, ellipse95, isLeft, place, type Point} from "./wheel_place";
import {Advice, RimPlane, Unknown, WeightAction, type Balance, type Compensation, type Verification} from "./wire";
import {isHidden} from "./words";

// In units of the drawing.
const kTyre = 108, kRim = 80, kNumerals = 120, kBand = (kTyre + kRim) / 2;
const kEllipsePoints = 48;

const at = ({x, y}: Point) => `${x.toFixed(2)} ${y.toFixed(2)}`;
const polar = (wheel: number, radius: number, angle_rad: number) =>
  place(wheel, radius * Math.cos(angle_rad), radius * Math.sin(angle_rad));

/** Grams that the rim stands for, so that the largest unbalance known fits in. */
export function fullScale(balances: readonly Balance[], checks: readonly Verification[]): number {
  const largest = Math.max(0, ...balances.filter(({state}) => state === Unknown.None)
    .map(({unbalance_g, sigma_g}) => unbalance_g + 2.5 * sigma_g), ...checks.map(({before_g}) => Math.hypot(...before_g)));
  return [5, 10, 20, 50, 100, 200, 500].find((scale) => scale >= largest) ?? 1000;
}

function rotationArrow(wheel: number): SVGElement {
  const [begin, end] = [polar(wheel, kBand, 0.35), polar(wheel, kBand, 1.05)];
  const tip = polar(wheel, kBand, 1.22);
  const [inner, outer] = [polar(wheel, kBand - 8, 1.03), polar(wheel, kBand + 8, 1.03)];
  const sweep = clockwise(wheel) > 0 ? 1 : 0;
  return svg("g", {class: "rotation"}, [
    svg("path", {d: `M${at(begin)}A${kBand} ${kBand} 0 0 ${sweep} ${at(end)}`}),
    svg("path", {class: "head", d: `M${at(tip)}L${at(inner)}L${at(outer)}z`})]);
}

function face(wheel: number): SVGElement[] {
  const numeral = (text: string, x: number, y: number) => svg("text", {x, y: y + 5, class: "numeral"}, [text]);
  const left = isLeft(wheel);
  return [
    svg("circle", {class: "tyre", r: kTyre}),
    svg("circle", {class: "rim", r: kRim}),
    svg("circle", {class: "half", r: kRim / 2}),
    svg("path", {class: "cross", d: `M${-kRim} 0H${kRim}M0 ${-kRim}V${kRim}`}),
    numeral("12", 0, -kNumerals), numeral("3", kNumerals, 0), numeral("6", 0, kNumerals), numeral("9", -kNumerals, 0),
    svg("path", {class: "mark", d: `M0 ${-kRim - 3}l-9 -20h18z`}),
    svg("text", {class: left ? "corner begin" : "corner end", x: left ? -132 : 132, y: 130},
        [left ? "◂ front" : "front ▸"]),
    rotationArrow(wheel)];
}

/** A weight on the rim; of one to take off dashed, of one that the wheel hides hollow. */
function weight(wheel: number, action: WeightAction, angle_rad: number, plane: RimPlane): SVGElement {
  const {x, y} = polar(wheel, kRim, angle_rad);
  const turn = clockwise(wheel) * angle_rad * 180 / Math.PI;
  const kind = {[WeightAction.Add]: "new", [WeightAction.Move]: "new", [WeightAction.Keep]: "kept",
                [WeightAction.Remove]: "off"}[action];
  return svg("rect", {class: `weight ${kind}${isHidden(plane) ? " hidden" : ""}`, x: -14, y: -7, width: 28, height: 14, rx: 3,
                      transform: `translate(${x.toFixed(2)} ${y.toFixed(2)}) rotate(${turn.toFixed(1)})`});
}

export class WheelDrawing {
  readonly element: SVGElement;
  private readonly ellipse = svg("path", {class: "ellipse"});
  private readonly before = svg("path", {class: "before"});
  private readonly vector = svg("path", {class: "vector"});
  private readonly spot = svg("circle", {class: "spot", r: 10});
  private readonly weights = svg("g");
  private readonly unknown = svg("text", {class: "unknown", y: 22}, ["?"]);
  private readonly scale: SVGElement;

  constructor(private readonly wheel: number) {
    const left = isLeft(wheel);
    this.scale = svg("text", {class: left ? "corner end" : "corner begin", x: left ? 132 : -132, y: 130});
    this.element = svg("svg", {viewBox: "-136 -136 272 272", class: "wheel", role: "img", "aria-hidden": "true"}, [
      ...face(wheel), this.ellipse, this.before, this.vector, this.weights, this.spot, this.unknown, this.scale]);
  }

  draw(balance: Balance | undefined, plan: Compensation | undefined, rim_g: number, check: Verification | undefined): void {
    const known = balance?.state === Unknown.None;
    setAttributes(this.element, {"data-known": String(known)});
    setText(this.scale, known ? `rim = ${weightMass(rim_g)}` : "");
    this.weights.replaceChildren();
    if (!known || !balance) return;
    const unit = kRim / rim_g;
    const [cosine = 0, sine = 0] = check?.before_g ?? [];
    setAttributes(this.before, {d: check ? `M0 0L${at(place(this.wheel, cosine * unit, sine * unit))}` : ""});
    const mean = [balance.unbalance_g * Math.cos(balance.angle_rad), balance.unbalance_g * Math.sin(balance.angle_rad)] as const;
    const outline = ellipse95(mean, balance.covariance_g2, kEllipsePoints)
      .map(([c, s]) => at(place(this.wheel, c * unit, s * unit)));
    setAttributes(this.ellipse, {d: `M${outline.join("L")}z`});
    setAttributes(this.vector, {d: `M0 0L${at(place(this.wheel, mean[0] * unit, mean[1] * unit))}`});
    const {x, y} = polar(this.wheel, kRim, balance.angle_rad);
    setAttributes(this.spot, {cx: x.toFixed(2), cy: y.toFixed(2)});
    if (plan?.advice !== Advice.Steps) return;
    for (let k = 0; k < plan.steps; ++k) {
      const action = plan.action[k] as WeightAction;
      if (action === WeightAction.Move)
        this.weights.append(weight(this.wheel, WeightAction.Remove, plan.from_angle_rad[k] ?? 0, (plan.from_plane[k] ?? 0) as RimPlane));
      this.weights.append(weight(this.wheel, action, plan.angle_rad[k] ?? 0, (plan.plane[k] ?? 0) as RimPlane));
    }
  }
}
