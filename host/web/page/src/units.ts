// Grams or ounces, kilometres or miles: a choice of each browser.  Messages are in SI.

type System = "metric" | "us";
const kKept = "units";
const kOunce_g = 28.349523125, kInch_m = 0.0254, kMile_m = 1609.344;

let system: System = localStorage.getItem(kKept) === "us" ? "us" : "metric";

export const unitSystem = () => system;

export function toggleUnits(): void {
  system = system === "metric" ? "us" : "metric";
  localStorage.setItem(kKept, system);
}

/** Never broken from its unit. */
export const withUnit = (value: string | number, unit: string | number) => `${value}\u00a0${unit}`;

const isUs = () => system === "us";
/** Without a trailing zero where it is whole. */
const short = (value: number, digits: number) => String(Number(value.toFixed(digits)));

/** "35.0 g", "1.23 oz" */
export const mass = (value_g: number) =>
  isUs() ? withUnit((value_g / kOunce_g).toFixed(2), "oz") : withUnit(value_g.toFixed(1), "g");
/** Of a weight that is bought: "35 g", "1.25 oz". */
export const weightMass = (value_g: number) =>
  isUs() ? withUnit(short(value_g / kOunce_g, 2), "oz") : withUnit(short(value_g, 1), "g");
/** Of a weight at a radius: "665 g·cm", "9.2 oz·in". */
export const moment = (value_g: number, radius_m: number) =>
  isUs() ? withUnit((value_g / kOunce_g * radius_m / kInch_m).toFixed(1), "oz·in")
    : withUnit((value_g * radius_m * 100).toFixed(0), "g·cm");
export const speed = (value_m_s: number) =>
  isUs() ? withUnit((value_m_s * 3600 / kMile_m).toFixed(0), "mph") : withUnit((3.6 * value_m_s).toFixed(0), "km/h");
/** The same as a number, for an axis or a table. */
export const speedNumber = (value_m_s: number) => (isUs() ? value_m_s * 3600 / kMile_m : 3.6 * value_m_s);
export const speedUnit = () => (isUs() ? "mph" : "km/h");
/** Along the rim: workshop rulers have both. */
export const length = (value_m: number) =>
  isUs() ? withUnit((value_m / kInch_m).toFixed(1), "in") : withUnit((1000 * value_m).toFixed(0), "mm");
/** "90–130 km/h", "35.2 ± 0.4 g": as C++ writes a number, or two, with its unit. */
const kInSentence = /(\d+(?:\.\d+)?)(?:( ± |–)(\d+(?:\.\d+)?))?[ \u00a0](km\/h|g)(?![\w·/])/g;

/** A sentence of the analyser in the units of this page's person. */
export function inUnits(sentence: string): string {
  if (!isUs()) return sentence;
  return sentence.replace(kInSentence, (_, first: string, between: string | undefined, second: string | undefined, unit: string) => {
    const converted = (number: string) => (unit === "g" ? (Number(number) / kOunce_g).toFixed(2) : (Number(number) * 1000 / kMile_m).toFixed(0));
    const numbers = second === undefined ? converted(first) : `${converted(first)}${between}${converted(second)}`;
    return withUnit(numbers, unit === "g" ? "oz" : "mph");
  });
}

/** What the button says that changes them. */
export const unitsName = () => (isUs() ? "oz · mph" : "g · km/h");
