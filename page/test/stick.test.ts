import { expect, test } from "vitest";
import { readGamepad, readPointer, combineArrows, Stick, maskLean } from "../src/driving/stick";
import type { Arrow } from "../src/protocol";

/** A key that types a letter, at the place where a US keyboard has another, or the same. */
function key(name: string, code = name.length === 1 ? `Key${name.toUpperCase()}` : name) {
  return { key: name, code, shiftKey: false };
}

function pad(pressed: number[], axes: number[] = [0, 0]): Pick<Gamepad, "axes" | "buttons"> {
  const buttons = Array.from({ length: 17 }, (_, index) => {
    const down = pressed.includes(index);
    return { pressed: down, touched: down, value: down ? 1 : 0 };
  });
  return { axes, buttons };
}

// how far the pointer is from the middle of a stick with a radius of 50 px, and how far that leans
const PULLS: [number, number, number, number][] = [
  [0, 0, 0, 0],
  [25, 0, 0.5, 0],
  [0, -50, 0, 1], // up on the screen is ahead
  [0, 20, 0, -0.4],
  [300, -400, 0.6, 0.8], // beyond the rim
];

test.each(PULLS)("a pointer at %d, %d leans %d to the right and %d up", (dx, dy, right, up) => {
  expect(readPointer(dx, dy, 50)).toEqual({ right, up });
});

const KEYS: [Arrow[], number, number][] = [
  [[], 0, 0],
  [["up"], 0, 1],
  [["left"], -1, 0],
  [["left", "right"], 0, 0],
  [["up", "down", "right"], 1, 0],
];

test.each(KEYS)("arrows %s", (ways, right, up) => {
  expect(combineArrows(ways)).toEqual({ right, up });
});

test("two arrows share the way", () => {
  const { right, up } = combineArrows(["up", "right"]);
  expect(Math.hypot(right, up)).toBeCloseTo(1);
  expect(right).toBeCloseTo(up);
});

test("a gamepad's stick has a dead zone, and its directional pad comes first", () => {
  expect(readGamepad(pad([], [0.08, 0.08])).lean).toEqual({ right: 0, up: 0 });
  expect(readGamepad(pad([], [0.5, -0.25])).lean).toEqual({ right: 0.5, up: 0.25 });
  expect(readGamepad(pad([12], [0.5, 0])).lean).toEqual({ right: 0, up: 1 });
  const { right, up } = readGamepad(pad([], [1, 1])).lean;
  expect(Math.hypot(right, up)).toBeCloseTo(1);
});

test("a gamepad's buttons hold behaviors, and Start pauses", () => {
  expect(readGamepad(pad([0, 2]))).toMatchObject({ held: [0, 1], start: false });
  expect(readGamepad(pad([9]))).toMatchObject({ held: [], start: true });
});

test("the pointer comes before the gamepad, and that before the keys", () => {
  const stick = new Stick();
  expect(stick.press(key("ArrowUp"))).toBe(true);
  expect(stick.press(key("x"))).toBe(false);
  expect(stick.lean).toEqual({ right: 0, up: 1 });
  stick.pad = readGamepad(pad([], [-0.5, 0]));
  expect(stick.lean).toEqual({ right: -0.5, up: 0 });
  stick.pulled = { right: 0.2, up: 0 };
  expect(stick.lean).toEqual({ right: 0.2, up: 0 });
  stick.pulled = null;
  stick.pad = readGamepad(pad([]));
  expect(stick.lean).toEqual({ right: 0, up: 1 });
  stick.lift(key("ArrowUp"));
  expect(stick.lean).toEqual({ right: 0, up: 0 });
});

test("what is held comes from keys, buttons on the page and the gamepad, and is there", () => {
  const stick = new Stick();
  stick.press(key("S"));
  stick.pushed.add(0);
  stick.pad = readGamepad(pad([1]));
  expect(stick.listHeld(3)).toEqual([0, 1, 2]);
  expect(stick.listHeld(2)).toEqual([0, 1]);
  stick.lift(key("s"));
  expect(stick.listHeld(3)).toEqual([0, 2]);
  stick.release();
  expect(stick.listHeld(3)).toEqual([]);
});

test("a stick does not lean where nothing is commanded", () => {
  const ways: Arrow[] = ["up", "left", "right"];
  expect(maskLean({ right: -0.5, up: 0.5 }, ways)).toEqual({ right: -0.5, up: 0.5 });
  expect(maskLean({ right: 0.5, up: -0.5 }, ways)).toEqual({ right: 0.5, up: 0 });
  expect(maskLean({ right: 0.5, up: -0.5 }, [])).toEqual({ right: 0, up: 0 });
});

test("behaviors are held by the place of their keys", () => {
  const stick = new Stick();
  stick.press(key("q", "KeyA")); // AZERTY
  stick.press(key("e", "KeyD")); // Dvorak
  stick.press(key("a", "KeyQ"));
  expect(stick.listHeld(6)).toEqual([0, 2]);
  stick.lift(key("Q", "KeyA")); // Caps Lock was pressed meanwhile
  expect(stick.listHeld(6)).toEqual([2]);
});
