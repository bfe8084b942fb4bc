import { expect, test } from "vitest";
import { decode, NONE, pictureIn } from "../src/frame";

/** A frame of two robots, one object, two features and so many sonars, as the server packs it. */
function packed(sonars = 1): ArrayBuffer {
  const buffer = new ArrayBuffer(24 + 2 * 16 + 16 + 2 * 4 + 2 + 4 * sonars + 4);
  const view = new DataView(buffer);
  const put16 = (at: number, value: number): void => view.setUint16(at, value, true);
  const put32 = (at: number, value: number): void => view.setFloat32(at, value, true);
  view.setUint8(0, 1);
  view.setUint8(1, 2 | 4);
  put16(2, 2);
  put16(4, 1);
  put16(6, 2);
  view.setFloat64(8, 48.3, true);
  put16(16, 3);
  put16(18, 1);
  view.setUint32(20, 483, true);
  put32(24, 1.5);
  put32(28, 2.5);
  put32(32, -0.5);
  put16(36, 4);
  put16(38, NONE);
  put32(40, 9);
  put16(54, 3);
  put16(56, 7);
  put16(58, 2);
  put32(60, 6);
  put32(64, 5);
  put16(68, 12);
  put16(70, 16);
  put32(72, 3.5);
  put32(76, NaN);
  put16(80, sonars);
  for (let index = 0; index < sonars; index += 1) put32(82 + 4 * index, 0.25 + index);
  view.setUint32(82 + 4 * sonars, 70_000, true);
  return buffer;
}

test("a picture is told from a frame by its first byte", async () => {
  const picture = pictureIn(new Uint8Array([2, 255, 216]).buffer);
  expect(picture?.type).toBe("image/jpeg");
  expect([...new Uint8Array((await picture?.arrayBuffer()) ?? new ArrayBuffer(0))]).toEqual([255, 216]);
  expect(pictureIn(packed())).toBeNull();
});

test("a frame is read as it was packed", () => {
  const frame = decode(packed());
  expect([frame.paused, frame.testing, frame.open]).toEqual([false, true, true]);
  expect([frame.time, frame.state, frame.agent, frame.tick]).toEqual([48.3, 3, 1, 483]);
  expect([...frame.robots.x]).toEqual([1.5, 9]);
  expect([frame.robots.y[0], frame.robots.heading[0], frame.robots.stored[0]]).toEqual([2.5, -0.5, 4]);
  expect([...frame.robots.doing]).toEqual([NONE, 3]);
  expect([frame.things.slot[0], frame.things.kind[0], frame.things.x[0], frame.things.y[0]]).toEqual([
    7, 2, 6, 5,
  ]);
  expect([frame.things.amount[0], frame.things.atFirst[0]]).toEqual([12, 16]);
  expect([...frame.features]).toEqual([3.5, NaN]);
  expect([...frame.sonars]).toEqual([0.25]);
  expect(frame.delivered).toBe(70_000);
});

test("more sonars than a byte counts are read", () => {
  const frame = decode(packed(300));
  expect(frame.sonars.length).toBe(300);
  expect([frame.sonars[0], frame.sonars[299]]).toEqual([0.25, 299.25]);
  expect(frame.delivered).toBe(70_000);
});

test("a frame of another kind is refused", () => {
  const buffer = packed();
  new DataView(buffer).setUint8(0, 2);
  expect(() => decode(buffer)).toThrow("kind 2");
});
