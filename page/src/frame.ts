/** One moment of the world as the server sends it, binary and little-endian. */

export const NONE = 65535;
const HEAD = 24;
const ROBOT = 16;
const THING = 16;

export interface Robots {
  count: number;
  x: Float32Array;
  y: Float32Array;
  heading: Float32Array;
  stored: Uint16Array;
  /** The index of the state each is in, among those of the automaton under training; NONE: another. */
  doing: Uint16Array;
}

export interface Things {
  count: number;
  slot: Uint16Array;
  kind: Uint16Array;
  x: Float32Array;
  y: Float32Array;
  amount: Uint16Array;
  atFirst: Uint16Array;
}

export interface Frame {
  paused: boolean;
  testing: boolean;
  open: boolean;
  time: number;
  tick: number;
  /** The index of the current state; NONE where there is none. */
  state: number;
  agent: number;
  robots: Robots;
  things: Things;
  /** The values of the chosen features; NaN is absent. */
  features: Float32Array;
  sonars: Float32Array;
  /** How much food all robots brought home. */
  delivered: number;
}

/** What a body of one's own draws of itself, where that is what the server sent; null where it sent a frame. */
export function pictureIn(buffer: ArrayBuffer): Blob | null {
  const isPicture = new Uint8Array(buffer, 0, 1)[0] === 2;
  return isPicture ? new Blob([new Uint8Array(buffer, 1)], { type: "image/jpeg" }) : null;
}

export function decode(buffer: ArrayBuffer): Frame {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== 1) throw new RangeError(`a frame of kind ${view.getUint8(0)}, not 1`);
  const bits = view.getUint8(1);
  const robots = view.getUint16(2, true);
  const things = view.getUint16(4, true);
  const features = view.getUint16(6, true);
  const thingsAt = HEAD + robots * ROBOT;
  const featuresAt = thingsAt + things * THING;
  const sonarsAt = featuresAt + features * 4;
  const sonars = view.getUint16(sonarsAt, true);
  return {
    paused: (bits & 1) !== 0,
    testing: (bits & 2) !== 0,
    open: (bits & 4) !== 0,
    time: view.getFloat64(8, true),
    state: view.getUint16(16, true),
    agent: view.getUint16(18, true),
    tick: view.getUint32(20, true),
    robots: robotsOf(view, HEAD, robots),
    things: thingsOf(view, thingsAt, things),
    features: floats(view, featuresAt, features),
    sonars: floats(view, sonarsAt + 2, sonars),
    delivered: view.getUint32(sonarsAt + 2 + sonars * 4, true),
  };
}

/** Whether two frames look the same in the world: what they differ in is time. */
export function isLike(one: Frame, other: Frame): boolean {
  const others = columns(other);
  return (
    one.open === other.open &&
    one.agent === other.agent &&
    columns(one).every((column, index) => areEqual(column, others[index] ?? []))
  );
}

function columns({ robots, things, features, sonars }: Frame): readonly ArrayLike<number>[] {
  const { x, y, heading, stored, doing } = robots;
  const { slot, kind, amount, atFirst } = things;
  return [x, y, heading, stored, doing, things.x, things.y, slot, kind, amount, atFirst, features, sonars];
}

/** Whether numbers are equal; NaN is equal to itself. */
function areEqual(one: ArrayLike<number>, other: ArrayLike<number>): boolean {
  if (one.length !== other.length) return false;
  for (let index = 0; index < one.length; index += 1) if (!Object.is(one[index], other[index])) return false;
  return true;
}

function robotsOf(view: DataView, start: number, count: number): Robots {
  const x = new Float32Array(count);
  const y = new Float32Array(count);
  const heading = new Float32Array(count);
  const stored = new Uint16Array(count);
  const doing = new Uint16Array(count);
  for (let index = 0, at = start; index < count; index += 1, at += ROBOT) {
    x[index] = view.getFloat32(at, true);
    y[index] = view.getFloat32(at + 4, true);
    heading[index] = view.getFloat32(at + 8, true);
    stored[index] = view.getUint16(at + 12, true);
    doing[index] = view.getUint16(at + 14, true);
  }
  return { count, x, y, heading, stored, doing };
}

function thingsOf(view: DataView, start: number, count: number): Things {
  const slot = new Uint16Array(count);
  const kind = new Uint16Array(count);
  const x = new Float32Array(count);
  const y = new Float32Array(count);
  const amount = new Uint16Array(count);
  const atFirst = new Uint16Array(count);
  for (let index = 0, at = start; index < count; index += 1, at += THING) {
    slot[index] = view.getUint16(at, true);
    kind[index] = view.getUint16(at + 2, true);
    x[index] = view.getFloat32(at + 4, true);
    y[index] = view.getFloat32(at + 8, true);
    amount[index] = view.getUint16(at + 12, true);
    atFirst[index] = view.getUint16(at + 14, true);
  }
  return { count, slot, kind, x, y, amount, atFirst };
}

function floats(view: DataView, start: number, count: number): Float32Array {
  const values = new Float32Array(count);
  for (let index = 0; index < count; index += 1) values[index] = view.getFloat32(start + index * 4, true);
  return values;
}
