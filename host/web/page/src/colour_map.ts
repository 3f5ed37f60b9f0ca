// Colours of a map from dark to light in even steps, which colour-blind people distinguish, too: viridis, by nine of
// its points (S. van der Walt, N. Smith, matplotlib, CC0).
const kPoints: readonly (readonly [number, number, number])[] = [
  [68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137], [53, 183, 121], [109, 205, 89],
  [253, 231, 37]];

/** @param share  0 .. 1; beyond, the end's colour */
export function mapColour(share: number): readonly [number, number, number] {
  const at = Math.min(1, Math.max(0, share)) * (kPoints.length - 1);
  const below = Math.min(kPoints.length - 2, Math.floor(at));
  const [a, b] = [kPoints[below], kPoints[below + 1]];
  const mix = (k: 0 | 1 | 2) => Math.round((a?.[k] ?? 0) + (at - below) * ((b?.[k] ?? 0) - (a?.[k] ?? 0)));
  return [mix(0), mix(1), mix(2)];
}
