/** Where ticks are on the timeline, and marks of times at round distances. */

import type { Episode, Series } from "../protocol";

/** Round distances between marks of time, s. */
const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1800, 3600];
/** The least room that a mark of time has, px. */
const ROOM = 70;

export interface Mark {
  tick: number;
  time: number;
}

/** The marks of an episode when a tick is `width` pixels wide. */
export function marks(episode: Episode, tick_s: number, width: number): Mark[] {
  const perSecond = width / tick_s;
  const step = STEPS.find((each) => each * perSecond >= ROOM) ?? 7200;
  const marks: Mark[] = [];
  const last = episode.from_s + (episode.end - episode.first) * tick_s;
  for (let time = Math.ceil(episode.from_s / step - 1e-9) * step; time < last; time += step) {
    marks.push({ tick: episode.first + (time - episode.from_s) / tick_s, time });
  }
  return marks;
}

/** The colors of labels, distinct for color-blind people; the last label, of no behavior, has no color. */
const COLORS = [
  "#4477aa",
  "#ee6677",
  "#228833",
  "#ccbb44",
  "#66ccee",
  "#aa3377",
  "#ee7733",
  "#009988",
  "#994455",
  "#997700",
];

/** The color of a label, by its index and the number of labels. */
export function color(label: number, labels: number): string {
  return label < 0 || label === labels - 1 ? "url(#none)" : (COLORS[label % COLORS.length] ?? "");
}

/** The same in CSS, where a pattern is none. */
export function swatch(label: number, labels: number): string {
  return label < 0 || label === labels - 1 ? "var(--wall)" : color(label, labels);
}

/** The points of polylines, in pieces without what is absent; y runs from 1 (least) to 0 (most). */
export function lines(
  { ticks, values, period }: Pick<Series, "ticks" | "values" | "period">,
  least: number,
  most: number,
): string[] {
  const room = most - least || 1;
  const marks: string[] = [];
  let piece: string[] = [];
  let before: number | null = null;
  const close = (): void => {
    if (piece.length > 0) marks.push(piece.join(" "));
    piece = [];
  };
  ticks.forEach((tick, index) => {
    const value = values[index] ?? null;
    const wraps = period !== undefined && value !== null && Math.abs(value - (before ?? value)) > period / 2;
    if (value === null || wraps) close();
    if (value !== null) piece.push(`${tick},${(1 - (value - least) / room).toFixed(4)}`);
    before = value;
  });
  close();
  return marks;
}
