// Sentences for people.
import {clockPosition, degrees} from "./wheel_place";
import {Advice, Unknown, WeightAction, type Balance, type Compensation, type Identification} from "./wire";

// A reason that the analyser learns to give does not compile before it has its sentence here.
const kReasons: Readonly<Record<Unknown, string>> = {
  [Unknown.None]: "known",
  [Unknown.TooShort]: "not enough driving at a steady speed yet",
  [Unknown.TooSlow]: "the car never went fast enough: speed up",
  [Unknown.NoReference]: "this wheel has no angle: look at its encoder and zero mark",
  [Unknown.IllConditioned]: "the drive does not determine it: drive at other speeds",
  [Unknown.UnfitVehicle]: "this vehicle's sensors or rates do not allow it",
  [Unknown.NoCommonTime]: "the nodes' samples do not lie on one grid of time",
  [Unknown.InStep]: "it turns in step with another wheel: take a bend or change lanes",
};

export const reason = (state: Unknown) => kReasons[state] ?? "for a reason that this page does not know";

// Never broken from its unit.
const unit = (value: string | number, of: string | number) => `${value}\u00a0${of}`;
const grams = (mass_g: number) => unit(mass_g.toFixed(1), "g");
/** "37° (clock 10:46)" */
const where = (wheel: number, angle_rad: number) =>
  `${degrees(angle_rad)}° (${unit("clock", clockPosition(wheel, angle_rad))})`;

/** What is on the wheel, or why it is not known. */
export function heavySpot(balance: Balance | undefined): string {
  if (!balance) return "Not known: nothing was heard of it.";
  if (balance.state !== Unknown.None) return `Not known: ${reason(balance.state)}.`;
  const sigma_deg = Math.ceil(balance.sigma_rad * 180 / Math.PI);
  return `Heavy spot at ${where(balance.wheel, balance.angle_rad)}, ${grams(balance.unbalance_g)}, ` +
    `±\u00a0${grams(balance.sigma_g)} ±\u00a0${sigma_deg}°.`;
}

function step(plan: Compensation, k: number): string {
  const at = where(plan.wheel, plan.angle_rad[k] ?? 0);
  const rim = plan.radii > 1 ? ` on ${Math.round(1000 * (plan.radius_m[k] ?? 0))} mm` : "";
  const mass = unit(Number((plan.mass_g[k] ?? 0).toFixed(1)), "g");
  switch (plan.action[k] as WeightAction) {
    case WeightAction.Add: return `Add ${mass} at ${at}${rim}`;
    case WeightAction.Move: return `Move ${mass} from ${where(plan.wheel, plan.from_angle_rad[k] ?? 0)} to ${at}${rim}`;
    case WeightAction.Remove: return `Remove ${mass} at ${at}${rim}`;
    case WeightAction.Keep: return `Keep ${mass} at ${at}${rim}`;
  }
}

/** What to do with the weights, one sentence each. */
export function whatToDo(plan: Compensation | undefined): string[] {
  if (!plan) return [];
  switch (plan.advice as Advice) {
    case Advice.Unknown: return [];
    case Advice.Steps: return Array.from({length: plan.steps}, (_, k) => `${step(plan, k)}.`);
    case Advice.LeaveUncertain: return ["Leave it: the unbalance is within its own uncertainty."];
    case Advice.LeaveSmall: return ["Leave it: no weight there is makes it enough less."];
  }
}

/** What that leaves, and how it is to be judged. */
export function whatIsLeft(plan: Compensation | undefined): string {
  if (!plan || plan.advice === Advice.Unknown) return "";
  const verdict = plan.residual_g <= plan.shop_g ? "within" : "MORE THAN";
  const shop = `${verdict} the ${unit(Number(plan.shop_g.toFixed(1)), "g")} that a shop leaves`;
  const iso = plan.permissible_g > 0 ? `; ISO\u00a021940 ${unit("G", Number(plan.grade_mm_s.toPrecision(2)))}` : "";
  return `That leaves ${grams(plan.residual_g)}, ${shop}${iso}.`;
}

export function whyIncurable(plan: Compensation | undefined): string {
  if (!plan || plan.size <= 0) return "";
  return new TextDecoder().decode(new Uint8Array(plan.incurable.slice(0, plan.size)));
}

/** What the estimates rest on. */
export function basis(identification: Identification | undefined): string {
  if (!identification) return "No analyser has said anything yet.";
  if (identification.state !== Unknown.None)
    return `Suspension not known: ${reason(identification.state)} (${identification.seconds_used.toFixed(0)} s so far).`;
  return `From ${identification.seconds_used.toFixed(0)} s of steady driving.`;
}

export function duration(seconds: number): string {
  const whole = Math.floor(seconds);
  const two = (value: number) => String(value).padStart(2, "0");
  return `${two(Math.floor(whole / 3600))}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}
