/** The path of the robot, colored by labels, with the place under the pointer. */

import type { RecordedSeries, Review } from "../protocol";
import type { Recording } from "./recording";
import { swatch } from "./scale";

const MARGIN = 0.06;

interface PathProps {
  recording: Recording;
  review: Review;
  series: RecordedSeries;
}

export function PathView({ recording, review, series }: PathProps) {
  const { path, path_ticks: ticks } = series;
  const xs = path.map(([x]) => x);
  const ys = path.map(([, y]) => y);
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const size = Math.max(right - left, high - low, 1e-6);
  const margin = size * MARGIN;
  const box = `${left - margin} ${-high - margin} ${right - left + 2 * margin} ${high - low + 2 * margin}`;
  const { pointed, selected } = recording;
  const at = pointed === null ? null : nearest(ticks, pointed);
  const here = at === null ? undefined : path[at];
  return (
    <section class="path-view" aria-label="Path">
      <svg viewBox={box} role="img" aria-label="Path of the robot">
        {pieces(review, ticks, path).map(({ points, label, first }) => (
          <polyline key={first} points={formatPath(points)} stroke={swatch(label, review.labels.length)} />
        ))}
        {selected !== null && (
          <polyline
            class="chosen"
            points={formatPath(
              path.filter(
                (_, index) => (ticks[index] ?? -1) >= selected.first && (ticks[index] ?? 0) < selected.end,
              ),
            )}
          />
        )}
        {here !== undefined && <circle cx={here[0]} cy={-here[1]} r={size / 60} />}
      </svg>
      <p class="tiny soft">
        {(right - left).toFixed(1)} m by {(high - low).toFixed(1)} m
      </p>
    </section>
  );
}

interface Piece {
  points: RecordedSeries["path"];
  label: number;
  first: number;
}

/** The path in pieces of one label. */
export function pieces(review: Review, ticks: readonly number[], path: RecordedSeries["path"]): Piece[] {
  const starts = new Set(review.episodes.map(({ first }) => first));
  return review.spans.map(({ first, end, label }) => {
    const points: [number, number][] = [];
    ticks.forEach((tick, index) => {
      // One point more, so that there is no gap before the next span of the same episode.
      const place = path[index];
      const before = ticks[index - 1] ?? -1;
      const inside = tick >= first && tick < end;
      const joins = tick >= end && before < end && before >= first && !starts.has(end);
      if (place !== undefined && (inside || joins)) points.push([place[0], place[1]]);
    });
    return { points, label, first };
  });
}

function formatPath(points: RecordedSeries["path"]): string {
  return points.map(([x, y]) => `${x},${-y}`).join(" ");
}

export function nearest(ticks: readonly number[], tick: number): number {
  let low = 0;
  let high = ticks.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if ((ticks[middle] ?? 0) <= tick) low = middle;
    else high = middle - 1;
  }
  return low;
}
