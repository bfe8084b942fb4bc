import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { DriveController } from "../src/driving/driving";
import type { DriveNews, DriveRequest } from "../src/protocol";

const PAD = { axes: [0, 0], buttons: [] };

let driving: DriveController;
let window: EventTarget;
let pads: unknown[];
let sent: DriveRequest[];
/** How often the stick was shown to have moved. */
let moves: number;
let end: () => void;

beforeEach(() => {
  vi.useFakeTimers();
  window = new EventTarget();
  pads = [null];
  sent = [];
  moves = 0;
  vi.stubGlobal("document", Object.assign(new EventTarget(), { hasFocus: () => true, hidden: false }));
  vi.stubGlobal("navigator", { getGamepads: () => pads });
  vi.stubGlobal("addEventListener", window.addEventListener.bind(window));
  vi.stubGlobal("removeEventListener", window.removeEventListener.bind(window));
  driving = new DriveController();
  driving.send = (request) => void sent.push(request);
  driving.moved.listen(() => (moves += 1));
  end = driving.listen();
  driving.steer();
  moves = 0;
});

afterEach(() => {
  end();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

/** The server says whether somebody drives. */
function hear(drives: boolean): void {
  driving.status = { driving: drives, automatic: false, held: ["load"] } as unknown as DriveNews;
  driving.news.tell();
}

test("no timer runs while nobody drives and no gamepad is there", () => {
  expect(vi.getTimerCount()).toBe(0);
  hear(false);
  expect(vi.getTimerCount()).toBe(0);
});

test("while driving the stick is sent all the time, and shown when it moves", () => {
  hear(true);
  vi.advanceTimersByTime(1000);
  expect([sent.length, moves]).toEqual([20, 0]);
  driving.stick.press({ key: "ArrowUp", code: "ArrowUp", shiftKey: false });
  driving.steer();
  expect(sent.at(-1)).toEqual({ do: "steer", right: 0, up: 1, held: [] });
  expect(moves).toBe(1);
  vi.advanceTimersByTime(1000);
  expect([sent.length, moves]).toEqual([41, 1]);
  hear(false);
  expect(vi.getTimerCount()).toBe(0);
});

// what happens to the stick, and whether anything of it is shown anew
const STICK: [string, (stick: DriveController["stick"]) => void, boolean][] = [
  ["nothing", () => undefined, false],
  ["it is grasped in the middle", (stick) => (stick.pulled = { right: 0, up: 0 }), true],
  ["it is held there", (stick) => (stick.pulled = { right: 0, up: 0 }), false],
  ["it is pulled", (stick) => (stick.pulled = { right: 0.5, up: 0 }), true],
  ["a button is held", (stick) => stick.pushed.add(0), true],
  ["a button that commands nothing", (stick) => stick.pushed.add(3), false],
  ["all is let go of", (stick) => stick.release(), true],
];

test("the stick is shown anew when something of it changes", () => {
  hear(true);
  for (const [what, act, shown] of STICK) {
    moves = 0;
    act(driving.stick);
    driving.steer();
    expect(moves, what).toBe(shown ? 1 : 0);
  }
});

test("a gamepad is looked at from when it is connected until it is gone", () => {
  pads = [PAD];
  window.dispatchEvent(new Event("gamepadconnected"));
  expect([driving.hasPad, vi.getTimerCount()]).toEqual([true, 1]);
  vi.advanceTimersByTime(1000);
  expect(moves).toBe(0);
  pads = [null];
  vi.advanceTimersByTime(100);
  expect([driving.hasPad, vi.getTimerCount()]).toEqual([false, 0]);
});

test("a gamepad that was there before the page is found, and again when the window has the focus", () => {
  end();
  pads = [PAD];
  document.hasFocus = () => false;
  end = driving.listen();
  expect(driving.hasPad).toBe(false);
  document.hasFocus = () => true;
  window.dispatchEvent(new Event("focus"));
  expect([driving.hasPad, vi.getTimerCount()]).toEqual([true, 1]);
});

test("what has ended looks at nothing", () => {
  hear(true);
  end();
  pads = [PAD];
  window.dispatchEvent(new Event("gamepadconnected"));
  window.dispatchEvent(new Event("focus"));
  expect([driving.hasPad, vi.getTimerCount()]).toEqual([false, 0]);
});

test("the robot rests when the window is left, and the drive pauses when the page is hidden", () => {
  hear(true);
  driving.stick.press({ key: "ArrowUp", code: "ArrowUp", shiftKey: false });
  driving.stick.pushed.add(0);
  driving.steer();
  expect(sent.at(-1)).toEqual({ do: "steer", right: 0, up: 1, held: [0] });
  window.dispatchEvent(new Event("blur"));
  expect(sent.at(-1)).toEqual({ do: "steer", right: 0, up: 0, held: [] });
  Object.assign(document, { hidden: true });
  document.dispatchEvent(new Event("visibilitychange"));
  expect(sent.at(-1)).toEqual({ do: "pause_drive" });
});
