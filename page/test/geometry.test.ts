import { expect, test } from "vitest";
import { fitView, panView, toScreen, toWorld, zoomView } from "../src/world/geometry";

const SCREEN = { width: 600, height: 500 };

test("the whole world fits between the margins, north up", () => {
  const view = fitView({ width: 12, height: 12 }, SCREEN, { top: 40, bottom: 60, sides: 20 });
  expect(toScreen(view, SCREEN, 0, 12)[1]).toBeCloseTo(40);
  expect(toScreen(view, SCREEN, 0, 0)[1]).toBeCloseTo(440);
});

test("what is under the pointer stays there while zooming", () => {
  const view = { x: 6, y: 5, scale: 40 };
  const before = toWorld(view, SCREEN, 123, 456);
  const after = toWorld(zoomView(view, SCREEN, 1.7, 123, 456), SCREEN, 123, 456);
  expect(after[0]).toBeCloseTo(before[0]);
  expect(after[1]).toBeCloseTo(before[1]);
});

test("the world cannot be pushed off the screen", () => {
  const view = { x: 6, y: 5, scale: 40 };
  const world = { width: 12, height: 10 };
  expect(panView(view, world, 80, 40)).toEqual({ x: 4, y: 6, scale: 40 });
  expect(panView(view, world, -9999, -9999)).toEqual({ x: 12, y: 0, scale: 40 });
});
