// The place of an angle on a wheel, seen from beside the car (common/vehicle/conventions.md).

/** In the order of all messages. */
export const kWheelNames = ["front left", "front right", "rear left", "rear right"] as const;

export const isLeft = (wheel: number) => wheel % 2 === 0;

/** +1 where the wheel turns clockwise for who looks at it from outside, driving forward: on the right. */
export const clockwise = (wheel: number) => (isLeft(wheel) ? -1 : 1);

/** Degrees 0 .. 359. */
export function degrees(angle_rad: number): number {
  return ((Math.round(angle_rad * 180 / Math.PI) % 360) + 360) % 360;
}

/** Where the angle, counted from the valve in the direction of rotation, is on a clock's face with the valve at 12, seen from
    outside: "4:46". */
export function clockPosition(wheel: number, angle_rad: number): string {
  const minutes = Math.round(clockwise(wheel) * angle_rad * 360 / Math.PI);
  const onFace = ((minutes % 720) + 720) % 720;
  return `${Math.floor(onFace / 60) || 12}:${String(onFace % 60).padStart(2, "0")}`;
}

/** The same backwards: "10:30" seen from outside, or degrees from the top in the direction of forward rotation ("45", "-30°");
    rad, undefined if it is neither. */
export function angleOf(wheel: number, text: string): number | undefined {
  const turn = 2 * Math.PI;
  const [, hour, minute] = /^\s*(\d{1,2}):([0-5]\d)\s*$/.exec(text) ?? [];
  if (hour !== undefined) {
    const hours = Number(hour) + Number(minute) / 60;
    return hours <= 13 ? ((clockwise(wheel) * hours / 12 * turn) % turn + turn) % turn : undefined;
  }
  if (/^\s*0?([1-9]|1[0-2])\s*$/.test(text)) return undefined;  // hours of the clock, or degrees?
  const [, degrees] = /^\s*([+-]?\d{1,3}(?:\.\d*)?)\s*(?:deg|°)?\s*$/.exec(text) ?? [];
  const angle = Number(degrees);
  return degrees !== undefined && Math.abs(angle) <= 360 ? angle / 360 * turn : undefined;
}

export interface Point {
  readonly x: number;
  readonly y: number;
}

/** On the drawing, y downwards, the valve on top: of (cos, sin) components, in their unit. */
export function place(wheel: number, cosine: number, sine: number): Point {
  return {x: clockwise(wheel) * sine, y: -cosine};
}

/** Outline of the region that holds the truth with 95 %, of (cos, sin) components and their covariance. */
export function ellipse95(mean: readonly [number, number], covariance: readonly number[][], points: number):
    [number, number][] {
  const kChiSquare = -2 * Math.log(0.05);  // of two degrees of freedom
  const [[a = 0, b = 0] = [], [, d = 0] = []] = covariance;
  // Lower triangle L of the covariance, L L' = covariance.
  const l11 = Math.sqrt(Math.max(a, 0));
  const l21 = l11 > 0 ? b / l11 : 0;
  const l22 = Math.sqrt(Math.max(d - l21 * l21, 0));
  const scale = Math.sqrt(kChiSquare);
  return Array.from({length: points}, (_, k) => {
    const angle = 2 * Math.PI * k / points;
    const [c, s] = [scale * Math.cos(angle), scale * Math.sin(angle)];
    return [mean[0] + l11 * c, mean[1] + l21 * c + l22 * s];
  });
}
