// Common parts of all plots.
import type {Car} from "./car";
import type {Spectral, Wish} from "./plot_ask";

/** A table as it is saved: columns of equal length, null where there is no value. */
export interface Table {
  readonly head: readonly string[];
  readonly columns: readonly (readonly (number | string | null)[])[];
}

/** What all plots are drawn from. */
export interface Scene {
  readonly car: Car;
  readonly spectral: Spectral;
  readonly nowMs: number;
}

export interface Plot {
  readonly id: string;
  readonly title: string;
  readonly element: HTMLElement;
  /** It is made of spectra: their window, block and average can be chosen. */
  readonly isSpectral: boolean;
  /** What it needs to be told. */
  wish(): Wish;
  draw(scene: Scene): void;
  /** As drawn. */
  table(): Table;
  /** As drawn, from top to bottom. */
  canvases(): HTMLCanvasElement[];
  /** What is drawn under the picture. */
  captions(): string[];
  /** Keeps what is drawn, to be drawn beside what comes; false: it has nothing to compare. */
  keepReference?(): void;
  dropReference?(): void;
}
