// Axes of the car in words (common/vehicle/conventions.md): x forward, y left, z up.
import type {Setup} from "./wire";

const kWords = [["forward", "backward"], ["left", "right"], ["up", "down"]] as const;
/** A knock from there goes the positive way along the axis. */
const kKnocks = ["from behind, forward", "from the right, to the left", "from below, upwards"] as const;

/** The axis that a direction is nearest to: 0 x, 1 y, 2 z. */
export function axisOf(direction: readonly number[]): 0 | 1 | 2 {
  const [x, y, z] = [0, 1, 2].map((k) => Math.abs(direction[k] ?? 0)) as [number, number, number];
  return z >= x && z >= y ? 2 : x >= y ? 0 : 1;
}

/** +1 if positive acceleration goes the positive way along its axis. */
export const signOf = (direction: readonly number[]) => ((direction[axisOf(direction)] ?? 0) < 0 ? -1 : 1);

/** "up"; "about up" where it is more than 5 degrees off. */
export function directionWord(direction: readonly number[]): string {
  const axis = axisOf(direction);
  const word = kWords[axis][signOf(direction) > 0 ? 0 : 1];
  return Math.abs(direction[axis] ?? 0) < Math.cos(5 * Math.PI / 180) ? `about ${word}` : word;
}

export const knockWord = (direction: readonly number[]) => kKnocks[axisOf(direction)];

/** Pairs of channels of a node that lie mirrored at the car's middle and whose positive directions are opposite: perhaps
    they are fitted so, perhaps somebody thought so. */
export function oppositePairs(setup: Setup): [number, number][] {
  const kSame_m = 0.05;
  const near = (a: number | undefined, b: number | undefined) => Math.abs((a ?? 0) - (b ?? 0)) < kSame_m;
  const found: [number, number][] = [];
  for (let a = 0; a < setup.channels; ++a)
    for (let b = 0; b < setup.channels; ++b) {
      const [p, q] = [setup.position_m[a], setup.position_m[b]], [d, e] = [setup.direction[a], setup.direction[b]];
      if (!p || !q || !d || !e || (p[1] ?? 0) < kSame_m || !near(p[1], -(q[1] ?? 0)) || !near(p[0], q[0]) || !near(p[2], q[2]))
        continue;
      if (axisOf(d) === axisOf(e) && signOf(d) !== signOf(e)) found.push([a, b]);
    }
  return found;
}
