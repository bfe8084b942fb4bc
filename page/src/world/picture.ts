/** What one drawing needs, and the pen it is drawn with: meters for places, pixels for lines and letters. */

import type { Scene, Session } from "../protocol";
import { toScreen, type Size, type View } from "./geometry";
import type { Motion } from "./motion";
import type { Palette } from "./palette";
import { isSmall } from "../words";

export const OVERLAYS = ["targets", "distances", "camera", "trail", "names"] as const;
export type Overlay = (typeof OVERLAYS)[number];

/** What a picture needs to know of the session. */
export type PictureSession = Pick<Session, "mode" | "features" | "activities">;

export interface Picture {
  pen: CanvasRenderingContext2D;
  screen: Size;
  view: View;
  scene: Scene;
  session: PictureSession | null;
  /** Whether a coordinator is trained, which gives the robots their orders. */
  led: boolean;
  motion: Motion;
  palette: Palette;
  overlays: ReadonlySet<Overlay>;
  /** What is under the pointer, or chosen. */
  marked: Mark | null;
  /** Where something dragged is, as it is not there on the server yet. */
  dragged: (Mark & { x: number; y: number }) | null;
}

export interface Mark {
  what: "robot" | "thing" | "obstacle";
  /** The robot's number, the object's slot, or which of the round obstacles. */
  of: number;
}

export function is(mark: Mark | null, what: Mark["what"], of: number): boolean {
  return mark !== null && mark.what === what && mark.of === of;
}

export function spot(picture: Picture, x: number, y: number): [number, number] {
  return toScreen(picture.view, picture.screen, x, y);
}

export function disc(pen: CanvasRenderingContext2D, x: number, y: number, radius: number): void {
  pen.moveTo(x + radius, y);
  pen.arc(x, y, radius, 0, 2 * Math.PI);
}

export function fillDisc(
  pen: CanvasRenderingContext2D,
  x: number,
  y: number,
  radius: number,
  color: string,
): void {
  pen.beginPath();
  disc(pen, x, y, radius);
  pen.fillStyle = color;
  pen.fill();
}

export function strokeRing(
  pen: CanvasRenderingContext2D,
  x: number,
  y: number,
  radius: number,
  color: string,
  width: number,
): void {
  pen.beginPath();
  disc(pen, x, y, radius);
  pen.strokeStyle = color;
  pen.lineWidth = width;
  pen.stroke();
}

/** A line through points on the screen. */
export function strokeLine(
  pen: CanvasRenderingContext2D,
  points: readonly (readonly [number, number])[],
  color: string,
  width: number,
): void {
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(x, y);
  pen.strokeStyle = color;
  pen.lineWidth = width;
  pen.stroke();
}

/** Letters with a rim of the ground's color, readable on anything. */
export function letters(picture: Picture, text: string, x: number, y: number, color: string): void {
  const { pen, palette } = picture;
  pen.font = `${isSmall() ? 13 : 11}px ui-sans-serif, system-ui, sans-serif`;
  pen.lineJoin = "round";
  pen.lineWidth = 3;
  pen.strokeStyle = palette.ground;
  pen.strokeText(text, x, y);
  pen.fillStyle = color;
  pen.fillText(text, x, y);
}
