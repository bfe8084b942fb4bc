import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { Stage } from "../src/world/stage";
import { Browser, frameAt, makeSession, makeWorld, SCENE, type MadeWorld } from "./world";

let browser: Browser;
let world: MadeWorld;
let stage: Stage<MadeWorld>;
let layer: unknown[];

beforeEach(() => {
  browser = new Browser();
  world = makeWorld();
  layer = ["review"];
  stage = new Stage(browser.canvas(), world, undefined, { draw: () => undefined, list: () => layer });
  arrive(0);
  browser.refresh(60);
  browser.drawings = 0;
});

afterEach(() => {
  stage.close();
  vi.unstubAllGlobals();
});

/** A frame arrives. */
function arrive(...frame: Parameters<typeof frameAt>): void {
  world.motion.take(frameAt(...frame));
  world.framed.tell();
}

/** How often the canvas is drawn in so many screen frames. */
function drawn(screens = 60): number {
  browser.drawings = 0;
  browser.refresh(screens);
  return browser.drawings;
}

test("nothing is drawn while nothing changes, and no screen frame is asked for", () => {
  expect(drawn(600)).toBe(0);
  expect(browser.requests).toBe(0);
});

test("each frame that arrives is drawn once", () => {
  for (let tick = 1; tick <= 10; tick += 1) {
    arrive(tick / 10, 2 + tick / 20);
    expect(drawn(6)).toBe(1);
  }
  expect(drawn()).toBe(0);
});

test("frames, news and the pointer within one screen frame are one drawing", () => {
  arrive(0.1, 3);
  arrive(0.2, 4);
  world.session = makeSession({ mode: "testing" });
  world.news.tell();
  stage.marked = { what: "thing", of: 0 };
  stage.draw();
  expect(drawn()).toBe(1);
});

test("a frame in which only time went on is not drawn", () => {
  arrive(0.1);
  arrive(0.2, 2, { paused: true, delivered: 4, state: 2 });
  expect(drawn()).toBe(0);
});

test("news of what is not visible is not drawn", () => {
  world.session = makeSession({ state: "forward", presses: 12, features: [...makeSession().features] });
  world.news.tell();
  world.news.tell();
  expect(drawn()).toBe(0);
});

const VISIBLE: [string, () => void][] = [
  ["the mode", () => (world.session = makeSession({ mode: "testing" }))],
  ["the features", () => (world.session = makeSession({ features: [{ label: "speed" }] }))],
  ["what robots are at", () => (world.session = makeSession({ activities: ["idle", "attack"] }))],
  ["a session that ends", () => (world.session = null)],
  ["the scene", () => (world.scene = { ...SCENE, discs: [] })],
  ["a coordinator that is trained", () => (world.sort = "platoon")],
  ["a picture", () => (world.image = {} as ImageBitmap)],
  ["control", () => (world.hasControl = false)],
  ["a world that becomes fixed", () => (world.live = { fixed: true })],
  ["what is drawn on the ground", () => (layer = ["another review"])],
];

test.each(VISIBLE)("%s is drawn once when it changes", (_, change) => {
  change();
  world.news.tell();
  expect(drawn()).toBe(1);
  world.news.tell();
  expect(drawn()).toBe(0);
});

test("a body that draws itself is drawn when its picture changes, not with each frame", () => {
  world.scene = { ...SCENE, drawing: "pictures" };
  world.news.tell();
  browser.refresh(60);
  arrive(0.1, 3);
  expect(drawn()).toBe(0);
  world.image = { width: 4 } as ImageBitmap;
  world.framed.tell();
  expect(drawn()).toBe(1);
});

test.each([
  ["nearer", () => stage.zoom(1.4)],
  ["much farther", () => stage.zoom(0.1)],
  ["around a pixel", () => stage.zoom(2, 10, 10)],
])("the view eases %s and stops", (_, act) => {
  act();
  expect(drawn(3)).toBe(3);
  expect(drawn(120)).toBeGreaterThan(0);
  expect(browser.requests).toBe(0);
  const there = { ...stage.view };
  stage.fit();
  drawn(120);
  expect(stage.view).not.toEqual(there);
  expect(browser.requests).toBe(0);
});

test("the view is dragged at once", () => {
  stage.pan(30, 0);
  expect(drawn()).toBe(1);
});

test("a view that is as wanted already is not drawn again", () => {
  stage.fit();
  world.news.tell();
  stage.zoom(1);
  stage.pan(0, 0);
  expect(drawn()).toBe(0);
});

test("what is dragged or pointed at is drawn with the next screen frame", () => {
  stage.dragged = { what: "robot", of: 1, x: 3, y: 3 };
  stage.draw();
  stage.draw();
  expect(drawn(1)).toBe(1);
  expect(drawn()).toBe(0);
});

test("nothing is drawn while the page is hidden, and once when it is shown", () => {
  browser.hide(true);
  for (let tick = 1; tick <= 10; tick += 1) arrive(tick / 10, 2 + tick / 20);
  stage.draw();
  browser.resize(320, 240);
  expect([browser.drawings, browser.requests]).toEqual([0, 0]);
  expect(drawn()).toBe(0);
  browser.hide(false);
  expect(drawn()).toBe(1);
});

test("what was asked for just before the page was hidden is drawn when it is shown", () => {
  arrive(0.1, 3);
  browser.document.hidden = true;
  browser.refreshOnce();
  expect(browser.drawings).toBe(0);
  browser.hide(false);
  expect(drawn()).toBe(1);
});

test("a page that is shown again is not drawn where nothing changed", () => {
  browser.hide(true);
  browser.hide(false);
  expect(drawn()).toBe(0);
});

test("another size is drawn at once, and the same size is not", () => {
  browser.resize(640, 480);
  expect(browser.drawings).toBe(0);
  browser.resize(320, 240);
  expect(browser.drawings).toBe(1);
  expect([stage.canvas.width, stage.canvas.height]).toEqual([640, 480]);
  expect(stage.screen).toEqual({ width: 320, height: 240 });
  expect(drawn()).toBe(0);
});

test("other colors are drawn once", () => {
  browser.dark.dispatchEvent(new Event("change"));
  expect(drawn()).toBe(1);
});

test("a stage that is closed draws no more", () => {
  arrive(0.1, 3);
  stage.close();
  arrive(0.2, 4);
  world.news.tell();
  browser.dark.dispatchEvent(new Event("change"));
  expect(drawn()).toBe(0);
});

test("a stage that is closed while the page is hidden is not drawn when it is shown", () => {
  browser.hide(true);
  arrive(0.1, 3);
  stage.close();
  browser.hide(false);
  expect([drawn(), browser.requests]).toEqual([0, 0]);
});
