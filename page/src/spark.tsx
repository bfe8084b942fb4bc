/** A sparkline: the last values of one feature, broken where it was absent or an angle went over its seam. */

import type { Feature } from "./protocol";
import { KEPT } from "./history";
import { isAngle } from "./words";

const WIDTH = 200;
const HEIGHT = 22;
const EDGE = 2;

export function Spark({ feature, values }: { feature: Feature; values: readonly number[] }) {
  return (
    <svg class="spark" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" aria-hidden="true">
      {isAngle(feature) && <line class="zero" x1="0" x2={WIDTH} y1={HEIGHT / 2} y2={HEIGHT / 2} />}
      <path d={line(feature, values)} vector-effect="non-scaling-stroke" />
    </svg>
  );
}

export function line(feature: Feature, values: readonly number[]): string {
  const angle = isAngle(feature);
  const heights = angle ? values.map((each) => Math.atan2(Math.sin(each), Math.cos(each))) : values;
  const [low, high] = range(feature, heights);
  const start = KEPT - values.length;
  let path = "";
  let pen = false;
  heights.forEach((height, index) => {
    const before = heights[index - 1] ?? NaN;
    if (Number.isNaN(height)) pen = false;
    else {
      const whole = pen && !(angle && Math.abs(height - before) > Math.PI);
      const x = ((start + index) / (KEPT - 1)) * WIDTH;
      const share = high > low ? (height - low) / (high - low) : 0.5;
      const y = HEIGHT - EDGE - share * (HEIGHT - 2 * EDGE);
      path += `${whole ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`;
      pen = true;
    }
  });
  return path;
}

function range(feature: Feature, values: readonly number[]): [number, number] {
  if (isAngle(feature)) return [-Math.PI, Math.PI];
  const present = values.filter((each) => !Number.isNaN(each));
  const high = present.reduce((most, each) => Math.max(most, each), -Infinity);
  const low = present.reduce((least, each) => Math.min(least, each), Infinity);
  if (feature.kind === "categorical") return [0, Math.max(1, (feature.labels?.length ?? 2) - 1)];
  return [Math.min(low, feature.unit === "m" ? 0 : low), high];
}
