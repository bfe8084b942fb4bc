import { expect, test } from "vitest";
import { isLike, type Frame } from "../src/frame";
import { Motion } from "../src/world/motion";
import { frameAt } from "./world";

/** A frame with one number of a column changed. */
function changed(of: "robots" | "things" | null, name: string, at = 0): Frame {
  const frame = frameAt(0);
  const parts = (of === null ? frame : frame[of]) as unknown as Record<string, Float32Array | Uint16Array>;
  const column = parts[name]!.slice();
  column[at] = 7;
  parts[name] = column;
  return frame;
}

const VISIBLE: [string, Frame][] = [
  ...["x", "y", "heading", "stored", "doing"].map(
    (name) => [name, changed("robots", name)] as [string, Frame],
  ),
  ...["slot", "kind", "x", "y", "amount", "atFirst"].map(
    (name) => [name, changed("things", name, 1)] as [string, Frame],
  ),
  ["a feature", changed(null, "features")],
  ["a feature that was absent", changed(null, "features", 2)],
  ["a sonar", changed(null, "sonars", 1)],
  ["one sonar less", frameAt(0, 2, { sonars: new Float32Array([1]) })],
  ["another robot", frameAt(0, 2, { agent: 0 })],
  ["no session", frameAt(0, 2, { open: false })],
];

test.each(VISIBLE)("a frame that differs in %s looks different", (_, frame) => {
  expect(isLike(frameAt(0), frame)).toBe(false);
  expect(isLike(frame, frame)).toBe(true);
});

test("frames that differ in time alone look the same, also where values are absent", () => {
  const later = frameAt(8.5, 2, { paused: true, testing: true, state: 3, delivered: 4 });
  expect(isLike(frameAt(0), later)).toBe(true);
});

// the tick and the place of the second robot, and whether it looks different, and how long the trail is then
const RUN: [string, number, number, boolean, number][] = [
  ["the first frame", 0, 2, true, 1],
  ["it stands", 0.1, 2, false, 1],
  ["it drives", 0.2, 2.05, true, 2],
  ["it hardly moves", 0.3, 2.06, true, 2],
  ["it drives on", 0.4, 2.1, true, 3],
  ["it was carried away", 0.5, 9, true, 1],
  ["many ticks at once", 5, 4.6, true, 2],
  ["the person went back in time", 0.4, 4.6, true, 1],
];

test("what changes from frame to frame, and the way it came", () => {
  const motion = new Motion();
  for (const [what, time, x, changes, trail] of RUN) {
    const before = motion.changes;
    motion.take(frameAt(time, x));
    expect(motion.changes - before, what).toBe(changes ? 1 : 0);
    expect(motion.trail.length, what).toBe(trail);
    expect(motion.pose(1), what).toEqual({ x: Math.fround(x), y: 2, heading: 1 });
  }
});

test("a world with another number of robots is another world", () => {
  const motion = new Motion();
  motion.take(frameAt(0));
  motion.take(frameAt(0.1, 3));
  const fewer = frameAt(0.2, 3);
  motion.take({ ...fewer, robots: { ...fewer.robots, count: 3 } });
  expect([motion.changes, motion.trail.length]).toEqual([3, 1]);
});
