/** The world in which a person drives, with the way of the robot in the colors of its labels. */

import { useEffect, useRef } from "preact/hooks";
import type { RecordedSeries } from "../protocol";
import { nearest, pieces } from "../recording/path";
import { swatch } from "../recording/scale";
import { drawOverlays } from "../world/overlays";
import { fillDisc, spot, strokeLine, type Picture } from "../world/picture";
import { Stage } from "../world/stage";
import type { DriveController } from "./driving";

/** A robot that moves less while it has one label stands, m. */
const STANDS_M = 0.05;
const MARGINS = { top: 14, bottom: 14, sides: 14 };

export function DrivenWorld({ driving }: { driving: DriveController }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    if (canvas.current === null) return undefined;
    const { recording } = driving;
    const stage = new Stage(canvas.current, driving, MARGINS, {
      draw: (picture) => {
        drawOverlays(picture);
        drawWay(picture, driving);
      },
      list: () => [recording.review, recording.series, recording.selected, recording.pointed],
    });
    const stop = recording.news.listen(() => stage.look());
    return () => {
      stop();
      stage.close();
    };
  }, [driving]);
  const { scene } = driving;
  return (
    <div class="driven-world">
      <canvas ref={canvas} role="img" aria-label={`The world ${scene?.scenario ?? ""} with the robot`} />
    </div>
  );
}

/** The way of the present episode by its labels, what is selected of it, and the place under the pointer. */
function drawWay(picture: Picture, { recording }: DriveController): void {
  const { review, series, selected, pointed } = recording;
  const begins = review?.episodes.at(-1)?.first ?? 0;
  if (review === null || series === null || series.path.length === 0) return;
  const { pen, palette } = picture;
  const { path, path_ticks: ticks } = series;
  const onScreen = (points: RecordedSeries["path"]) => points.map(([x, y]) => spot(picture, x, y));
  pen.lineCap = "round";
  pen.lineJoin = "round";
  for (const { points, label, first } of pieces(review, ticks, path)) {
    if (first < begins) continue;
    const color = label === review.labels.length - 1 ? palette.wall : swatch(label, review.labels.length);
    strokeLine(pen, onScreen(points), color, 4);
    const [from, to] = [points[0], points.at(-1)];
    if (from === undefined || to === undefined || Math.hypot(to[0] - from[0], to[1] - from[1]) > STANDS_M)
      continue;
    fillDisc(pen, ...spot(picture, ...from), 5, color); // what it did on the spot, such as turning
  }
  if (selected !== null && selected.first >= begins) {
    const inside = path.filter((_, index) => {
      const tick = ticks[index] ?? -1;
      return tick >= selected.first && tick < selected.end;
    });
    pen.globalAlpha = 0.35;
    strokeLine(pen, onScreen(inside), palette.ink, 9);
    pen.globalAlpha = 1;
  }
  const place = pointed === null || pointed < begins ? undefined : path[nearest(ticks, pointed)];
  if (place === undefined) return;
  fillDisc(pen, ...spot(picture, ...place), 6, palette.ink);
}
