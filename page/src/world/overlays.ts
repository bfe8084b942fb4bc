/** What is shown on demand: the way it came, lines to targets, measured distances, what the camera sees. */

import { toDegrees, useMinusSign, plain } from "../words";
import { fillDisc, letters, spot, strokeLine, type PictureSession, type Picture } from "./picture";
import { pose } from "./robots";

const TO_RADIANS = Math.PI / 180;
/** A line shorter than this has no room for words; the values stand in the left column. */
const NEAR_PX = 100;

export function drawOverlays(picture: Picture): void {
  const frame = picture.motion.last;
  if (frame === null || picture.session === null || frame.agent >= frame.robots.count) return;
  if (picture.overlays.has("trail")) drawTrail(picture);
  if (picture.overlays.has("camera")) drawCamera(picture, frame.agent);
  if (picture.overlays.has("distances")) drawDistances(picture, frame.agent, frame.sonars);
  if (picture.overlays.has("targets")) drawTargets(picture, frame.agent, picture.session, frame.features);
}

function drawTrail(picture: Picture): void {
  const { pen, motion, palette, session } = picture;
  const trail = motion.trail.slice(0, -1).map(({ x, y }) => spot(picture, x, y));
  if (motion.last !== null) {
    const { x, y } = pose(picture, motion.last.agent);
    trail.push(spot(picture, x, y));
  }
  pen.globalAlpha = 0.6;
  pen.setLineDash([1, 5]);
  pen.lineCap = "round";
  strokeLine(pen, trail, session?.mode === "testing" ? palette.test : palette.train, 2);
  pen.setLineDash([]);
  pen.globalAlpha = 1;
}

/** A cone from the robot: angles left of ahead, in degrees. */
function cone(picture: Picture, robot: number, fromDeg: number, toDeg: number, length: number): void {
  const { pen, view } = picture;
  const at = pose(picture, robot);
  const [x, y] = spot(picture, at.x, at.y);
  const from = -(at.heading + fromDeg * TO_RADIANS);
  const to = -(at.heading + toDeg * TO_RADIANS);
  pen.beginPath();
  pen.moveTo(x, y);
  pen.arc(x, y, length * view.scale, from, to, true);
  pen.closePath();
}

function drawCamera(picture: Picture, robot: number): void {
  const { pen, scene, palette } = picture;
  for (const camera of scene.cameras[scene.robot_type[robot] ?? 0] ?? []) {
    cone(
      picture,
      robot,
      -camera.view_deg / 2,
      camera.view_deg / 2,
      camera.range ?? scene.width + scene.height,
    );
    pen.globalAlpha = 0.1;
    pen.fillStyle = palette.accent;
    pen.fill();
    pen.globalAlpha = 1;
  }
}

/** What the range sensors measure, from the robot's rim: a cone for an arc, a ray with a dot where it hits for a beam. */
function drawDistances(picture: Picture, robot: number, readings: Float32Array): void {
  const { pen, scene, palette } = picture;
  const type = scene.robot_type[robot] ?? 0;
  const rim = scene.types[type]?.radius ?? 0;
  (scene.sonars[type] ?? []).forEach((arc, index) => {
    const reading = readings[index] ?? NaN;
    const answered = !Number.isNaN(reading);
    const hit = answered && reading < arc.range * 0.99;
    const beam = arc.from_deg === arc.to_deg;
    cone(picture, robot, arc.from_deg, arc.to_deg, rim + (answered ? reading : arc.range));
    pen.fillStyle = palette.train;
    if (!beam) {
      pen.globalAlpha = hit ? 0.2 : 0.08;
      pen.fill();
    }
    pen.globalAlpha = beam ? (hit ? 0.35 : 0.12) : 0.5;
    pen.lineWidth = 1;
    pen.strokeStyle = palette.train;
    if (!answered) pen.setLineDash([3, 4]);
    pen.stroke();
    pen.setLineDash([]);
    if (beam && hit) drawHit(picture, robot, arc.from_deg, rim + reading);
    pen.globalAlpha = 1;
  });
}

/** A dot where a beam hits, so far from the middle of the robot. */
function drawHit(picture: Picture, robot: number, deg: number, away: number): void {
  const at = pose(picture, robot);
  const angle = at.heading + deg * TO_RADIANS;
  const [x, y] = spot(picture, at.x + away * Math.cos(angle), at.y + away * Math.sin(angle));
  picture.pen.globalAlpha = 0.9;
  fillDisc(picture.pen, x, y, 2.5, picture.palette.train);
}

/** A line to each target that the automaton knows distance and angle of, as it senses them. */
function drawTargets(picture: Picture, robot: number, session: PictureSession, values: Float32Array): void {
  const { pen, palette } = picture;
  const at = pose(picture, robot);
  const sensed = picture.motion.pose(robot);
  for (const { name, distance, angle } of listTargets(session, values)) {
    const bearing = sensed.heading + angle;
    const x = sensed.x + Math.cos(bearing) * distance;
    const y = sensed.y + Math.sin(bearing) * distance;
    const from = spot(picture, at.x, at.y);
    const to = spot(picture, x, y);
    pen.setLineDash([2, 5]);
    strokeLine(pen, [from, to], palette.accent, 1.5);
    pen.setLineDash([]);
    if (Math.hypot(to[0] - from[0], to[1] - from[1]) < NEAR_PX) continue;
    const text = `${plain(name)} · ${distance.toFixed(2)} m, ${useMinusSign(`${toDegrees(angle)}°`)}`;
    letters(picture, text, (from[0] + to[0]) / 2 + 8, (from[1] + to[1]) / 2 - 6, palette.accent);
  }
}

interface Aim {
  name: string;
  distance: number;
  angle: number;
}

export function listTargets(session: PictureSession, values: Float32Array): Aim[] {
  const reading = new Map(session.features.map((feature, index) => [feature.label, values[index] ?? NaN]));
  const list: Aim[] = [];
  for (const [label, distance] of reading) {
    const name = /^distance_to\((.+)\)$/.exec(label)?.[1];
    const angle = reading.get(`angle_to(${name})`);
    if (name === undefined || angle === undefined || Number.isNaN(distance + angle)) continue;
    list.push({ name, distance, angle });
  }
  return list;
}
