/** The fixed things: the grid, walls, polygons, round obstacles. */

import { toWorld } from "./geometry";
import { paint } from "./palette";
import { fillDisc, is, spot, strokeRing, type Picture } from "./picture";

const STEPS = [1, 2, 5, 10, 20, 50, 100];
const FINEST_PX = 28;

export function drawGround(picture: Picture): void {
  const { pen, screen, palette } = picture;
  pen.fillStyle = palette.ground;
  pen.fillRect(0, 0, screen.width, screen.height);
  drawGrid(picture);
  drawSolid(picture);
  drawWalls(picture);
}

function drawGrid(picture: Picture): void {
  const { pen, screen, view, palette } = picture;
  const step = STEPS.find((each) => each * view.scale >= FINEST_PX) ?? 200;
  const [west, north] = toWorld(view, screen, 0, 0);
  const [east, south] = toWorld(view, screen, screen.width, screen.height);
  pen.beginPath();
  for (let x = Math.ceil(west / step) * step; x <= east; x += step) {
    const at = Math.round(spot(picture, x, 0)[0]) + 0.5;
    pen.moveTo(at, 0);
    pen.lineTo(at, screen.height);
  }
  for (let y = Math.ceil(south / step) * step; y <= north; y += step) {
    const at = Math.round(spot(picture, 0, y)[1]) + 0.5;
    pen.moveTo(0, at);
    pen.lineTo(screen.width, at);
  }
  pen.strokeStyle = palette.grid;
  pen.lineWidth = 1;
  pen.stroke();
}

function drawSolid(picture: Picture): void {
  const { pen, scene, view, palette } = picture;
  for (const polygon of scene.polygons) {
    pen.beginPath();
    for (const [x, y] of polygon) pen.lineTo(...spot(picture, x, y));
    pen.closePath();
    pen.fillStyle = palette.solid;
    pen.fill();
  }
  scene.discs.forEach((each, index) => {
    const at = is(picture.dragged, "obstacle", index) ? (picture.dragged ?? each) : each;
    const [x, y] = spot(picture, at.x, at.y);
    fillDisc(pen, x, y, each.radius * view.scale, paint(each.color, palette.solid));
    if (is(picture.marked, "obstacle", index))
      strokeRing(pen, x, y, each.radius * view.scale + 4, palette.accent, 2);
  });
}

function drawWalls(picture: Picture): void {
  const { pen, scene, palette } = picture;
  const [left, top] = spot(picture, 0, scene.height);
  const [right, bottom] = spot(picture, scene.width, 0);
  pen.beginPath();
  pen.roundRect(left, top, right - left, bottom - top, 4);
  for (const [x0, y0, x1, y1] of scene.walls) {
    pen.moveTo(...spot(picture, x0, y0));
    pen.lineTo(...spot(picture, x1, y1));
  }
  pen.strokeStyle = palette.wall;
  pen.lineWidth = 3;
  pen.lineCap = "round";
  pen.stroke();
}
