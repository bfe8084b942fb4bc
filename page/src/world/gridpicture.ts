/** The picture of many worlds side by side: small maps, the ways of robots, and green or red where a run has ended. */

import type { GridWorld, Scene, WorldGrid } from "../protocol";
import { findOutcome, findPlace, type Cell } from "../worldgrid";
import { paint, type Palette } from "./palette";
import { extent } from "./things";

const LEAST_PX = 2;
const TRAIL_ALPHA = 0.45;

export interface GridPicture {
  pen: CanvasRenderingContext2D;
  palette: Palette;
  scene: Scene;
  grid: WorldGrid;
  cells: readonly Cell[];
  /** The time in the worlds, s. */
  time: number;
}

export function drawGridPicture(picture: GridPicture): void {
  picture.grid.worlds.forEach((world, index) => {
    const cell = picture.cells[index];
    if (cell !== undefined) drawWorld(picture, world, cell);
  });
}

function drawWorld(picture: GridPicture, world: GridWorld, cell: Cell): void {
  const { pen, palette, grid, time } = picture;
  const outcome = findOutcome(world, time);
  const color = outcome === "works" ? palette.food : outcome === "fails" ? palette.danger : palette.wall;
  const scale = cell.width / grid.width;
  const spot = (x: number, y: number): [number, number] => [
    cell.left + x * scale,
    cell.top + (grid.height - y) * scale,
  ];
  pen.save();
  pen.beginPath();
  pen.roundRect(cell.left, cell.top, cell.width, cell.height, 3);
  pen.fillStyle = palette.pane;
  pen.fill();
  if (outcome !== "running") {
    pen.globalAlpha = 0.16;
    pen.fillStyle = color;
    pen.fill();
    pen.globalAlpha = 1;
  }
  pen.clip();
  drawSolid(picture, world, scale, spot);
  drawThings(picture, world, scale, spot);
  world.paths.forEach((path, robot) => drawRobot(picture, path, robot === 0, color, scale, spot));
  pen.restore();
  pen.beginPath();
  pen.roundRect(cell.left + 0.5, cell.top + 0.5, cell.width - 1, cell.height - 1, 3);
  pen.strokeStyle = color;
  pen.lineWidth = outcome === "running" ? 1 : 2;
  pen.stroke();
}

type Spot = (x: number, y: number) => [number, number];

function drawSolid({ pen, palette }: GridPicture, world: GridWorld, scale: number, spot: Spot): void {
  pen.beginPath();
  for (const [x0 = 0, y0 = 0, x1 = 0, y1 = 0] of world.lines) {
    pen.moveTo(...spot(x0, y0));
    pen.lineTo(...spot(x1, y1));
  }
  pen.strokeStyle = palette.wall;
  pen.lineWidth = 1;
  pen.stroke();
  pen.fillStyle = palette.solid;
  for (const [x = 0, y = 0, radius = 0] of world.discs) fill(pen, spot(x, y), radius * scale);
}

function drawThings({ pen, palette, scene }: GridPicture, world: GridWorld, scale: number, spot: Spot): void {
  for (const { kind, x, y, amount } of world.things) {
    const of = scene.classes[kind];
    if (of === undefined) continue;
    pen.fillStyle = paint(of.color, of.food ? palette.food : of.home ? palette.accent : palette.soft);
    const size = Math.max(extent(of, amount) * scale, LEAST_PX);
    const [left, top] = spot(x, y);
    if (of.home) pen.fillRect(left - size, top - size, 2 * size, 2 * size);
    else fill(pen, [left, top], size);
  }
}

function drawRobot(
  { pen, palette, grid, time }: GridPicture,
  path: readonly number[],
  trained: boolean,
  color: string,
  scale: number,
  spot: Spot,
): void {
  const [x, y] = findPlace(grid.times, path, time);
  if (trained) {
    pen.beginPath();
    for (let index = 0; 2 * index < path.length && (grid.times[index] ?? 0) < time; index += 1)
      pen.lineTo(...spot(path[2 * index] ?? 0, path[2 * index + 1] ?? 0));
    pen.lineTo(...spot(x, y));
    pen.globalAlpha = TRAIL_ALPHA;
    pen.strokeStyle = color;
    pen.lineWidth = 1.5;
    pen.stroke();
    pen.globalAlpha = 1;
  }
  pen.fillStyle = trained ? palette.ink : palette.robot;
  fill(pen, spot(x, y), Math.max(grid.robot_radius * scale, LEAST_PX));
}

function fill(pen: CanvasRenderingContext2D, [x, y]: readonly [number, number], radius: number): void {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fill();
}
