/** What is shown on demand: the way it came, lines to targets, sonar cones, what the camera sees. */

import type { Session } from "../protocol";
import { degrees, minus } from "../words";
import { letters, spot, type Picture } from "./picture";
import { pose } from "./robots";

const TO_RADIANS = Math.PI / 180;
/** A line shorter than this has no room for words; the values stand in the left column. */
const NEAR_PX = 70;

export function drawOverlays(picture: Picture): void {
  const frame = picture.motion.last;
  if (frame === null || picture.desk === null || frame.agent >= frame.robots.count) return;
  if (picture.overlays.has("trail")) drawTrail(picture);
  if (picture.overlays.has("camera")) drawCamera(picture, frame.agent);
  if (picture.overlays.has("sonars")) drawSonars(picture, frame.agent, frame.sonars);
  if (picture.overlays.has("targets")) drawTargets(picture, frame.agent, picture.desk, frame.features);
}

function drawTrail(picture: Picture): void {
  const { pen, motion, palette, desk } = picture;
  pen.beginPath();
  for (const { x, y } of motion.trail.slice(0, -1)) pen.lineTo(...spot(picture, x, y));
  const frame = motion.last;
  if (frame !== null) {
    const { x, y } = pose(picture, frame.agent);
    pen.lineTo(...spot(picture, x, y));
  }
  pen.strokeStyle = desk?.mode === "testing" ? palette.test : palette.train;
  pen.globalAlpha = 0.6;
  pen.lineWidth = 2;
  pen.setLineDash([1, 5]);
  pen.lineCap = "round";
  pen.stroke();
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

function drawSonars(picture: Picture, robot: number, readings: Float32Array): void {
  const { pen, scene, palette } = picture;
  const sonars = scene.sonars[scene.robot_type[robot] ?? 0] ?? [];
  sonars.forEach((sonar, index) => {
    const reading = readings[index] ?? NaN;
    const heard = !Number.isNaN(reading);
    cone(picture, robot, sonar.from_deg, sonar.to_deg, heard ? reading : sonar.range);
    pen.globalAlpha = heard && reading < sonar.range * 0.99 ? 0.2 : 0.08;
    pen.fillStyle = palette.train;
    pen.fill();
    pen.globalAlpha = 0.5;
    pen.lineWidth = 1;
    pen.strokeStyle = palette.train;
    if (!heard) pen.setLineDash([3, 4]);
    pen.stroke();
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  });
}

/** A line to each target that the automaton knows distance and angle of, as it senses them. */
function drawTargets(picture: Picture, robot: number, desk: Session, values: Float32Array): void {
  const { pen, palette } = picture;
  const at = pose(picture, robot);
  const sensed = picture.motion.pose(robot, 1);
  for (const { name, distance, angle } of aims(desk, values)) {
    const bearing = sensed.heading + angle;
    const x = sensed.x + Math.cos(bearing) * distance;
    const y = sensed.y + Math.sin(bearing) * distance;
    const [fromX, fromY] = spot(picture, at.x, at.y);
    const [toX, toY] = spot(picture, x, y);
    pen.beginPath();
    pen.moveTo(fromX, fromY);
    pen.lineTo(toX, toY);
    pen.setLineDash([2, 5]);
    pen.lineWidth = 1.5;
    pen.strokeStyle = palette.accent;
    pen.stroke();
    pen.setLineDash([]);
    if (Math.hypot(toX - fromX, toY - fromY) < NEAR_PX) continue;
    const text = `${name} · ${distance.toFixed(2)} m, ${minus(`${degrees(angle)}°`)}`;
    letters(picture, text, (fromX + toX) / 2 + 8, (fromY + toY) / 2 - 6, palette.accent);
  }
}

interface Aim {
  name: string;
  distance: number;
  angle: number;
}

export function aims(desk: Session, values: Float32Array): Aim[] {
  const reading = new Map(desk.features.map((feature, index) => [feature.label, values[index] ?? NaN]));
  const found: Aim[] = [];
  for (const [label, distance] of reading) {
    const name = /^distance_to\((.+)\)$/.exec(label)?.[1];
    const angle = reading.get(`angle_to(${name})`);
    if (name === undefined || angle === undefined || Number.isNaN(distance + angle)) continue;
    found.push({ name, distance, angle });
  }
  return found;
}
