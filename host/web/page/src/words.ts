// Sentences for people.
import type {Car} from "./car";
import {utf8} from "./text";
import {inUnits, length, mass, moment, speed, weightMass, withUnit} from "./units";
import {clockPosition, degrees} from "./wheel_place";
import {
  Advice, RimPlane, Unknown, WeightCheckState, WeightCheckVerdict, WeightAction, WeightKind, WeightPlacement, type Balance, type Compensation,
  type Identification, type Verification,
} from "./wire";

// A new reason of the analyser does not compile before it has its sentence here.
const kReasons: Readonly<Record<Unknown, string>> = {
  [Unknown.None]: "known",
  [Unknown.TooShort]: "not enough driving at a steady speed yet",
  [Unknown.TooSlow]: "the car never went fast enough: speed up",
  [Unknown.NoReference]: "this wheel has no angle: look at its encoder and zero mark",
  [Unknown.IllConditioned]: "the drive does not determine it: drive at other speeds",
  [Unknown.UnfitVehicle]: "this vehicle's sensors or rates do not allow it",
  [Unknown.NoCommonTime]: "the nodes' samples do not lie on one grid of time",
  [Unknown.InStep]: "it turns in step with another wheel: change lanes or take a bend",
};

const wholeSeconds = (seconds: number) => withUnit(Math.ceil(seconds), "s");

/** Why it is not known, with what to do about it as far as numbers tell. */
export function reason(state: Unknown, identification?: Identification): string {
  if (identification && state === Unknown.TooShort && identification.seconds_needed > 0) {
    const [used, more] = [identification.seconds_used, identification.seconds_needed - identification.seconds_used];
    return `${withUnit(Math.floor(used), "s")} at a steady speed, ${wholeSeconds(Math.max(more, 1))} more for a first estimate`;
  }
  if (identification && state === Unknown.TooSlow && identification.least_speed_m_s > 0)
    return `speed up to ${speed(identification.least_speed_m_s)} or more`;
  return kReasons[state] ?? "for a reason that this page does not know";
}

/** "37° (clock 10:46)" */
const where = (wheel: number, angle_rad: number) =>
  `${degrees(angle_rad)}° (${withUnit("clock", clockPosition(wheel, angle_rad))})`;

/** "123 mm ahead of the valve": along the rim, the shorter way; ahead is in the direction of rotation. */
function alongRim(angle_rad: number, radius_m: number): string {
  const turn = 2 * Math.PI;
  const ahead = ((angle_rad % turn) + turn) % turn;
  return ahead <= Math.PI ? `${length(ahead * radius_m)} ahead of the valve`
    : `${length((turn - ahead) * radius_m)} behind the valve`;
}

/** What is on the wheel, or why it is not known. */
export function heavySpot(balance: Balance | undefined, identification?: Identification): string {
  if (!balance) return "Not known: nothing was heard of it.";
  if (balance.state !== Unknown.None) return `Not known: ${reason(balance.state, identification)}.`;
  const sigma_deg = Math.min(180, Math.ceil(balance.sigma_rad * 180 / Math.PI));
  return `Heavy spot at ${where(balance.wheel, balance.angle_rad)}, ${mass(balance.unbalance_g)}, ` +
    `±\u00a0${mass(balance.sigma_g)} ±\u00a0${sigma_deg}°; ${moment(balance.unbalance_g, balance.weight_radius_m)}.`;
}

export interface Step {
  readonly text: string;
  /** Where with a ruler. */
  readonly detail: string;
}

const kPutting: Readonly<Record<WeightKind, string>> = {
  [WeightKind.NotGiven]: "Add", [WeightKind.Clip]: "Clip", [WeightKind.Adhesive]: "Stick",
};
const kHeld: Readonly<Record<WeightKind, string>> = {
  [WeightKind.NotGiven]: "", [WeightKind.Clip]: " clip", [WeightKind.Adhesive]: " adhesive weight",
};
const kSides: Readonly<Record<RimPlane, string>> = {[RimPlane.NotGiven]: "", [RimPlane.Inner]: "inner", [RimPlane.Outer]: "outer"};

/** " on the outer flange", " in the inner plane (160 mm)", or nothing where nobody told it and there is but one radius. */
function onPlace(kind: WeightKind, plane: RimPlane, radius: string): string {
  if (plane === RimPlane.NotGiven) return radius && ` on ${radius}`;
  const side = kind === WeightKind.Clip ? ` on the ${kSides[plane]} flange` : ` in the ${kSides[plane]} plane`;
  return side + (radius && ` (${radius})`);
}

/** Who stands beside the car sees the drawing's side of the wheel only. */
export const isHidden = (plane: RimPlane) => plane === RimPlane.Inner;

function step(plan: Compensation, k: number): Step {
  const angle_rad = plan.angle_rad[k] ?? 0, radius_m = plan.radius_m[k] ?? 0, from_m = plan.from_radius_m[k] ?? 0;
  const kind = (plan.kind[k] ?? 0) as WeightKind, plane = (plan.plane[k] ?? 0) as RimPlane;
  const from = (plan.from_plane[k] ?? 0) as RimPlane;
  const radius = (value_m: number) => (plan.radii > 1 ? length(value_m) : "");
  const place = `${where(plan.wheel, angle_rad)}${onPlace(kind, plane, radius(radius_m))}`;
  const grams = weightMass(plan.mass_g[k] ?? 0);
  const there = kind === WeightKind.NotGiven ? grams : `the ${grams}${kHeld[kind]}`;
  const detail = alongRim(angle_rad, radius_m) + (isHidden(plane) ? "; behind the wheel" : "");
  switch (plan.action[k] as WeightAction) {
    case WeightAction.Add: return {text: `${kPutting[kind]} ${grams} at ${place}`, detail};
    case WeightAction.Move: {
      const old = from === plane && from_m === radius_m ? "" : onPlace(kind, from, radius(from_m));
      return {text: `Move ${there} from ${where(plan.wheel, plan.from_angle_rad[k] ?? 0)}${old} to ${place}`, detail: `to ${detail}`};
    }
    case WeightAction.Remove: return {text: `Remove ${there} at ${place}`, detail};
    case WeightAction.Keep: return {text: `Keep ${there} at ${place}`, detail};
  }
}

/** What to do with the weights. */
export function whatToDo(plan: Compensation | undefined): Step[] {
  if (!plan) return [];
  switch (plan.advice as Advice) {
    case Advice.Unknown: return [];
    case Advice.Steps: return Array.from({length: plan.steps}, (_, k) => step(plan, k));
    case Advice.LeaveUncertain: return [{text: "Leave it: the unbalance is within its own uncertainty", detail: ""}];
    case Advice.LeaveSmall: return [{text: "Leave it: no weight there is makes it enough less", detail: ""}];
  }
}

/** What that leaves, and how it is to be judged. */
export function whatIsLeft(plan: Compensation | undefined, balance: Balance | undefined): string {
  if (!plan || !balance || plan.advice === Advice.Unknown) return "";
  const verdict = plan.residual_g <= plan.shop_g ? "within" : "MORE THAN";
  const shop = `${verdict} the ${weightMass(plan.shop_g)} that a shop leaves`;
  const rotor = plan.by_rotor ? "" : " by the unsprung mass";
  const iso = plan.permissible_g > 0
    ? `; ISO\u00a021940 ${withUnit("G", Number(plan.grade_mm_s.toPrecision(2)))}${rotor}` : "";
  const seats = Number.isFinite(plan.seat_now_m_s2)
    ? ` At the seats ${withUnit(`${plan.seat_now_m_s2.toPrecision(2)} → ${plan.seat_left_m_s2.toPrecision(2)}`, "m/s²")}.` : "";
  return `That leaves ${mass(plan.residual_g)} (${moment(plan.residual_g, balance.weight_radius_m)}), ${shop}${iso}.${seats}`;
}

export interface Progress {
  /** 0 .. 1 of the driving that is needed. */
  readonly share: number;
  readonly isDone: boolean;
  readonly text: string;
}

/** Toward the wanted sigma: that decides, not the time. */
export function progress(balance: Balance | undefined, plan: Compensation | undefined,
                         identification: Identification | undefined): Progress {
  if (!balance || balance.state !== Unknown.None || !plan) {
    const share = identification && identification.seconds_needed > 0
      ? Math.min(0.99, identification.seconds_used / identification.seconds_needed) : 0;
    return {share: balance?.state === Unknown.TooShort ? share : 0, isDone: false, text: "not known yet"};
  }
  const wanted = `±\u00a0${weightMass(plan.wanted_sigma_g)}`;
  if (plan.seconds_wanted === 0) return {share: 1, isDone: true, text: `done: better than ${wanted}`};
  if (!Number.isFinite(plan.seconds_wanted))
    return {share: Math.min(0.99, (plan.wanted_sigma_g / balance.sigma_g) ** 2), isDone: false,
            text: `${wanted} is wanted; driving on like this does not reach it`};
  return {share: balance.seconds_used / (balance.seconds_used + plan.seconds_wanted), isDone: false,
          text: `${wholeSeconds(plan.seconds_wanted)} more for ${wanted}`};
}

const kVerdicts: Readonly<Record<WeightCheckVerdict, string>> = {
  [WeightCheckVerdict.Open]: "Not known well enough yet: drive on",
  [WeightCheckVerdict.Good]: "GOOD: no more is left than a shop leaves",
  [WeightCheckVerdict.Less]: "Better, and more is left than a shop leaves",
  [WeightCheckVerdict.Unchanged]: "NO BETTER than before",
  [WeightCheckVerdict.More]: "WORSE than before",
};
const kPlacements: Readonly<Record<WeightPlacement, string>> = {
  [WeightPlacement.NotJudged]: "",
  [WeightPlacement.AsWanted]: "The unbalance changed as the weights should change it.",
  [WeightPlacement.Mirrored]: "It changed as if the weight were MIRRORED at the valve: count the angle in the direction of " +
    "rotation, seen from outside the car.",
  [WeightPlacement.Opposite]: "It changed as if the weight were AT the heavy spot, not opposite to it.",
  [WeightPlacement.Elsewhere]: "It did not change as the weights should change it: are they where they should be?",
  [WeightPlacement.NoEffect]: "It did not change: were the weights fitted?",
};

/** What weights have done to a wheel; empty: nobody knows. */
export const verdictOf = (of: Verification | undefined) =>
  of?.state === WeightCheckState.Known ? kVerdicts[of.verdict as WeightCheckVerdict] : "";

/** The drive before the weights beside this one. */
export function weightCheckLines(of: Verification | undefined): string[] {
  if (!of) return [];
  const text = utf8(of.text, of.size);
  const grams = (vector: readonly number[]) => mass(Math.hypot(...vector));
  switch (of.state as WeightCheckState) {
    case WeightCheckState.ReadingBefore: return [`The drive before (${text}) is being read.`];
    case WeightCheckState.NotComparable: return [`No comparison: ${text}.`];
    case WeightCheckState.BeforeUnknown: return [`No comparison: the drive before (${text}) did not tell this wheel.`];
    case WeightCheckState.AfterUnknown: return [`Before (${text}): ${grams(of.before_g)}; this drive does not tell it yet.`];
    case WeightCheckState.Known: {
      const [percent, sigma] = [100 * of.reduction, Math.max(1, Math.ceil(100 * of.sigma_reduction))];
      const by = percent >= 0 ? `${percent.toFixed(0)} % less` : `${(-percent).toFixed(0)} % more`;
      return [`Before ${grams(of.before_g)}, now ${grams(of.after_g)}: ${by}, ±\u00a0${sigma}\u00a0%. ` +
                `${verdictOf(of)}.`, kPlacements[of.placement as WeightPlacement]]
        .filter((line) => line !== "");
    }
  }
}

/** What the newest estimate rests on. */
export function remarks(car: Car): string[] {
  const newest = car.remarks.get(0)?.message;
  if (!newest) return [];
  return Array.from({length: newest.remarks}, (_, k) => car.remarks.get(k)?.message)
    .flatMap((remark) => (remark && remark.time_ns === newest.time_ns ? [utf8(remark.text, remark.size)] : []))
    .map(inUnits).map((text) => `${text.charAt(0).toUpperCase()}${text.slice(1)}.`);
}

export function whyIncurable(plan: Compensation | undefined): string {
  if (!plan || plan.size <= 0) return "";
  return inUnits(utf8(plan.incurable, plan.size));
}

/** What the estimates rest on. */
export function basis(identification: Identification | undefined): string {
  if (!identification) return "No analyser has said anything yet.";
  if (identification.state !== Unknown.None)
    return `Suspension not known: ${reason(identification.state, identification)}.`;
  return `From ${identification.seconds_used.toFixed(0)} s of steady driving.`;
}

export function duration(seconds: number): string {
  const whole = Math.floor(seconds);
  const two = (value: number) => String(value).padStart(2, "0");
  return `${two(Math.floor(whole / 3600))}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

/** As ISO 8601 writes it, of this browser's own time zone. */
export const localTime = (time_us: number) => new Date(time_us / 1000).toLocaleString("sv-SE");
