/** The robots: a ring with a line where each heads; the trained one in the color of its mode. */

import { paint } from "./palette";
import { disc, fillDisc, is, letters, spot, strokeRing, type Picture } from "./picture";
import type { Pose } from "./motion";
import { plain } from "../words";

const LEAST_PX = 3;
const DOING = ["#3a6fd8", "#e08a2b", "#5a9a34", "#c2407f", "#2ba3b8", "#8f4aa3", "#d9ac14", "#8a5a3c"];

/** A crowd is drawn in one stroke for each type, so that a thousand robots stay smooth. */
export function drawRobots(picture: Picture): void {
  const { motion, scene, session } = picture;
  const frame = motion.last;
  if (frame === null) return;
  const trained = session === null ? -1 : frame.agent;
  if (session !== null && picture.led) drawDoing(picture);
  scene.types.forEach((_, type) => drawCrowd(picture, type, trained));
  if (trained >= 0 && trained < frame.robots.count) drawTrained(picture, trained);
  if (picture.overlays.has("names") && frame.robots.count > 1 && frame.robots.count <= 24) drawNames(picture);
  for (let robot = 0; robot < frame.robots.count; robot += 1) {
    if (is(picture.marked, "robot", robot) && robot !== trained) {
      const { x, y } = pose(picture, robot);
      strokeRing(picture.pen, ...spot(picture, x, y), size(picture, robot) + 4, picture.palette.accent, 2);
    }
  }
}

/** A coordinator's robots, each in the color of its activity. */
function drawDoing(picture: Picture): void {
  const { pen, motion } = picture;
  const robots = motion.last?.robots;
  if (robots === undefined) return;
  pen.globalAlpha = 0.35;
  for (let robot = 0; robot < robots.count; robot += 1) {
    const { x, y } = pose(picture, robot);
    const color = DOING[(robots.doing[robot] ?? 0) % DOING.length] ?? "";
    fillDisc(pen, ...spot(picture, x, y), size(picture, robot) + 7, color);
  }
  pen.globalAlpha = 1;
}

export function pose(picture: Picture, robot: number): Pose {
  const at = picture.motion.pose(robot);
  return is(picture.dragged, "robot", robot) ? { ...at, ...picture.dragged } : at;
}

/** A robot's radius, px. */
export function size(picture: Picture, robot: number): number {
  const type = picture.scene.types[picture.scene.robot_type[robot] ?? 0];
  return Math.max((type?.radius ?? 0.2) * picture.view.scale, LEAST_PX);
}

function drawCrowd(picture: Picture, type: number, trained: number): void {
  const { pen, scene, motion, palette } = picture;
  const count = motion.last?.robots.count ?? 0;
  pen.beginPath();
  for (let robot = 0; robot < count; robot += 1) {
    if (robot !== trained && scene.robot_type[robot] === type) outline(picture, robot);
  }
  pen.fillStyle = palette.pane;
  pen.fill();
  pen.strokeStyle = paint(scene.types[type]?.color ?? null, palette.robot);
  pen.lineWidth = thin(picture, scene.types[type]?.radius ?? 0.2, 2);
  pen.stroke();
}

/** A line's width, thinner around what is small. */
function thin(picture: Picture, radius: number, most: number): number {
  return Math.max(1, Math.min(most, radius * picture.view.scale * 0.28));
}

function outline(picture: Picture, robot: number): void {
  const at = pose(picture, robot);
  const [x, y] = spot(picture, at.x, at.y);
  const radius = size(picture, robot);
  disc(picture.pen, x, y, radius);
  picture.pen.moveTo(x, y);
  picture.pen.lineTo(x + Math.cos(at.heading) * radius, y - Math.sin(at.heading) * radius);
}

function drawTrained(picture: Picture, robot: number): void {
  const { pen, palette, session, motion } = picture;
  const at = pose(picture, robot);
  const [x, y] = spot(picture, at.x, at.y);
  const radius = size(picture, robot);
  const color = session?.mode === "testing" ? palette.test : palette.train;
  pen.globalAlpha = 0.16;
  fillDisc(pen, x, y, radius + 9, color);
  pen.globalAlpha = 1;
  pen.beginPath();
  outline(picture, robot);
  pen.fillStyle = palette.pane;
  pen.fill();
  pen.strokeStyle = color;
  pen.lineWidth = Math.max(1.5, Math.min(3, radius * 0.28));
  pen.lineCap = "round";
  pen.stroke();
  const stored = motion.last?.robots.stored[robot] ?? 0;
  if (stored > 0) letters(picture, `carries ${stored}`, x + radius + 10, y + radius + 10, palette.soft);
}

function drawNames(picture: Picture): void {
  const count = picture.motion.last?.robots.count ?? 0;
  for (let robot = 0; robot < count; robot += 1) {
    const at = pose(picture, robot);
    const [x, y] = spot(picture, at.x, at.y);
    const doing = picture.led
      ? picture.session?.activities[picture.motion.last?.robots.doing[robot] ?? -1]
      : "";
    letters(
      picture,
      `${robot + 1} ${plain(doing ?? "")}`,
      x - 3,
      y - size(picture, robot) - 6,
      picture.palette.soft,
    );
  }
}
