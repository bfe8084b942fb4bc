/** The handle of a chosen robot, ahead of it: dragged with the mouse or a finger, it turns the robot. */

import { fillDisc, spot, strokeLine, strokeRing, type Picture } from "./picture";
import { pose, size } from "./robots";

/** Half of what a finger needs, px. */
export const GRASP_PX = 22;
const AWAY_PX = 46;
const SHOWN_PX = 13;

export interface Handle {
  robot: number;
  x: number;
  y: number;
  /** It is behind the robot where there is no room ahead. */
  behind: boolean;
}

/** Draw the handle, if a robot is chosen; `held` stays on its side of the robot. */
export function drawHandle(picture: Picture, held: Handle | null): Handle | null {
  const { pen, palette, marked, motion } = picture;
  const robot = marked?.of ?? -1;
  if (marked?.what !== "robot" || motion.last === null || robot >= motion.last.robots.count) return null;
  const handle = held ?? [false, true].map((behind) => place(picture, robot, behind)).find(fits(picture));
  const { x, y, behind } = place(picture, robot, handle?.behind ?? false);
  const at = pose(picture, robot);
  const [fromX, fromY] = spot(picture, at.x, at.y);
  const share = size(picture, robot) / Math.hypot(x - fromX, y - fromY);
  const rim = [fromX + (x - fromX) * share, fromY + (y - fromY) * share] as const;
  strokeLine(pen, [rim, [x, y]], palette.accent, 1.5);
  fillDisc(pen, x, y, SHOWN_PX, palette.pane);
  strokeRing(pen, x, y, SHOWN_PX, palette.accent, 2);
  drawArrow(pen, x, y, palette.accent);
  return { robot, x, y, behind };
}

function place(picture: Picture, robot: number, behind: boolean): Handle {
  const at = pose(picture, robot);
  const [x, y] = spot(picture, at.x, at.y);
  const away = (AWAY_PX + size(picture, robot)) * (behind ? -1 : 1);
  return { robot, x: x + away * Math.cos(at.heading), y: y - away * Math.sin(at.heading), behind };
}

function fits({ screen }: Picture): (handle: Handle) => boolean {
  return ({ x, y }) =>
    x >= GRASP_PX && x <= screen.width - GRASP_PX && y >= GRASP_PX && y <= screen.height - GRASP_PX;
}

/** An arrow around the middle of the handle. */
function drawArrow(pen: CanvasRenderingContext2D, x: number, y: number, color: string): void {
  const radius = SHOWN_PX / 2;
  pen.beginPath();
  pen.arc(x, y, radius, 0, 1.5 * Math.PI);
  pen.stroke();
  pen.beginPath();
  pen.moveTo(x + 4.5, y - radius);
  pen.lineTo(x - 0.5, y - radius - 4);
  pen.lineTo(x - 0.5, y - radius + 4);
  pen.fillStyle = color;
  pen.fill();
}
