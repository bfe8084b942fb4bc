/** The objects: food with what is left of it, homes, balls, anything else. */

import type { ObjectClass } from "../protocol";
import { plain } from "../words";
import { paint } from "./palette";
import { fillDisc, is, letters, spot, strokeLine, strokeRing, type Picture } from "./picture";

const LEAST_PX = 4;
const FLAG_PX = 18;

/** Half the extent of an object on the ground, m. */
export function extent(kind: ObjectClass, atFirst: number): number {
  if (kind.food) return Math.max(kind.radius, Math.min(0.1 * Math.sqrt(atFirst), 0.6));
  return Math.max(kind.radius, kind.home ? 0.24 : 0.08);
}

export function drawThings(picture: Picture): void {
  const frame = picture.motion.last;
  if (frame === null) return;
  for (let index = 0; index < frame.things.count; index += 1) drawThing(picture, index);
}

function drawThing(picture: Picture, index: number): void {
  const { pen, scene, motion, view, palette } = picture;
  const frame = motion.last;
  const kind = scene.classes[frame?.things.kind[index] ?? -1];
  if (frame === null || kind === undefined) return;
  const slot = frame.things.slot[index] ?? 0;
  const amount = frame.things.amount[index] ?? 0;
  const atFirst = frame.things.atFirst[index] ?? 0;
  const dragged = is(picture.dragged, "thing", slot) ? picture.dragged : null;
  const { x: xs, y: ys } = frame.things;
  const [x, y] = spot(picture, dragged?.x ?? xs[index] ?? 0, dragged?.y ?? ys[index] ?? 0);
  const size = Math.max(extent(kind, atFirst) * view.scale, LEAST_PX);
  const color = paint(kind.color, kind.food ? palette.food : kind.home ? palette.accent : palette.soft);
  const left = kind.food ? amount / Math.max(atFirst, 1) : 1;

  pen.fillStyle = color;
  if (kind.marker) drawMarker(picture, x, y, size, color);
  else if (kind.home) {
    pen.beginPath();
    pen.roundRect(x - size, y - size, 2 * size, 2 * size, size * 0.35);
    pen.fill();
  } else {
    if (kind.food) {
      pen.globalAlpha = 0.18;
      fillDisc(pen, x, y, size, color);
      pen.globalAlpha = 1;
    }
    if (left > 0) fillDisc(pen, x, y, size * Math.sqrt(left), color);
  }
  if (kind.pushable) strokeRing(pen, x, y, size + 2, palette.ink, 1);
  if (is(picture.marked, "thing", slot)) strokeRing(pen, x, y, size + 5, palette.accent, 2);
  if (picture.overlays.has("names")) {
    const name = kind.food ? (amount > 0 ? `${amount} ${plain(kind.name)}` : "empty") : plain(kind.name);
    letters(picture, name, x + size + 6, y + 4, palette.soft);
  }
}

/** A flag on a pole that stands in a ring: nothing else in a world looks like it. */
function drawMarker(picture: Picture, x: number, y: number, size: number, color: string): void {
  const { pen, palette } = picture;
  const high = Math.max(2.6 * size, FLAG_PX);
  pen.globalAlpha = 0.25;
  fillDisc(pen, x, y, size, color);
  pen.globalAlpha = 1;
  strokeRing(pen, x, y, size, color, 2);
  const top = [x, y - high] as const;
  strokeLine(pen, [[x, y], top], palette.ink, 2);
  pen.beginPath();
  pen.moveTo(...top);
  pen.lineTo(x + 0.6 * high, y - 0.78 * high);
  pen.lineTo(x, y - 0.56 * high);
  pen.closePath();
  pen.fill();
}
