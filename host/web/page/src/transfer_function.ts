// Transfer function and coherence of a pair of channels, from the parts that the analyser sends.
import {frequencies, joined} from "./plot_data";
import type {Transfer} from "./wire";

/** H1 is right with noise on the output, H2 with noise on the input, Hv with as much on both. */
export type Estimator = "h1" | "h2" | "hv";

export interface TransferFunctionCurves {
  readonly hz: number[];
  readonly magnitude: number[];
  /** Where the magnitude is with 95 %; null: anywhere. */
  readonly least: (number | null)[];
  readonly greatest: (number | null)[];
  /** `least` on an axis of logarithms, which has no 0: far below the magnitude instead. */
  readonly least_drawn: (number | null)[];
  /** -180 .. 180; null where the circle of 95 % holds 0. */
  readonly phase_deg: (number | null)[];
  readonly coherence: number[];
  /** Of input and output, (m/s²)²/Hz. */
  readonly input: number[];
  readonly output: number[];
  /** That unrelated channels stay below in 95 % of the bins. */
  readonly by_chance: number[];
}

const kFarBelow = 1e-6;

/** |h2| = |h1| / coherence, |hv| = |h1| / sqrt(coherence): transfer_t. */
const kPower: Readonly<Record<Estimator, number>> = {h1: 0, h2: 1, hv: 0.5};

export function transferFunctionCurves(parts: readonly Transfer[], estimator: Estimator): TransferFunctionCurves {
  const coherence = joined(parts, (part) => part.coherence);
  const re = joined(parts, (part) => part.h1_re), im = joined(parts, (part) => part.h1_im);
  const radius = joined(parts, (part) => part.radius_95);
  const h1 = re.map((x, k) => Math.hypot(x, im[k] ?? 0));
  const scale = coherence.map((gamma2) => (gamma2 > 0 ? gamma2 ** -kPower[estimator] : 0));
  const band = (sign: number) => h1.map((size, k) => {
    const reach = radius[k] ?? Infinity;
    return Number.isFinite(reach) ? Math.max(0, size + sign * reach) * (scale[k] ?? 0) : null;
  });
  const magnitude = h1.map((size, k) => size * (scale[k] ?? 0)), least = band(-1);
  return {
    hz: frequencies(parts), magnitude, least, greatest: band(1),
    least_drawn: least.map((value, k) => (value === null ? null : Math.max(value, kFarBelow * (magnitude[k] ?? 0)))),
    phase_deg: re.map((x, k) => ((radius[k] ?? Infinity) < (h1[k] ?? 0) ? Math.atan2(im[k] ?? 0, x) * 180 / Math.PI : null)),
    coherence, input: joined(parts, (part) => part.input), output: joined(parts, (part) => part.output),
    by_chance: coherence.map(() => parts[0]?.coherence_by_chance ?? 1),
  };
}

/** By how much the output is behind the input: the mean slope of the phase over all bins that say anything, weighed by
    what their coherence tells. Seconds; nothing if none does. */
export function meanDelay_s(parts: readonly Transfer[]): number | undefined {
  const [part] = parts;
  if (!part) return undefined;
  const re = joined(parts, ({h1_re}) => h1_re), im = joined(parts, ({h1_im}) => h1_im);
  const coherence = joined(parts, (one) => one.coherence);
  let sumRe = 0, sumIm = 0;
  for (let k = 1; k + 1 < re.length; ++k) {  // not at 0 Hz
    const least = Math.min(coherence[k] ?? 0, coherence[k + 1] ?? 0);
    if (least <= part.coherence_by_chance) continue;
    const [a, b, c, d] = [re[k] ?? 0, im[k] ?? 0, re[k + 1] ?? 0, im[k + 1] ?? 0];
    const size = Math.hypot(a, b) * Math.hypot(c, d);
    if (size === 0) continue;
    const weight = least / Math.max(1 - least, 1e-3) / size;  // 1 over the variance of a phase, about
    sumRe += weight * (c * a + d * b);
    sumIm += weight * (d * a - c * b);
  }
  return sumRe === 0 && sumIm === 0 ? undefined : -Math.atan2(sumIm, sumRe) / (2 * Math.PI * part.step_hz);
}
