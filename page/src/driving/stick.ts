/** Where the stick is: by the mouse or a finger, the arrow keys, or a gamepad; and which buttons are held. */

import { listPressed, PADS } from "../gamepad";
import { type Key, keyboard } from "../keyboard";
import { ARROWS } from "../keys";
import type { Arrow } from "../protocol";

/** How far it leans, -1 to 1 each; up is above 0. */
export interface Lean {
  right: number;
  up: number;
}

export const REST: Lean = { right: 0, up: 0 };
/** The places of the keys of the behaviors that are held, in order. */
export const HOLDS = ["KeyA", "KeyS", "KeyD", "KeyF", "KeyG", "KeyH"];
/** A gamepad's stick that leans less is at rest: it never quite returns to the middle. */
const LOOSE = 0.12;
/** The buttons of a gamepad for behaviors that are held: A, X, B, Y, and those at the shoulders. */
export const PAD_HOLDS = [0, 2, 1, 3, 4, 5];
/** The button of a gamepad that begins and pauses. */
export const PAD_START = 9;

/** The lean of a pointer, as far from the middle as it is; on the rim at most. */
export function readPointer(dx: number, dy: number, radius: number): Lean {
  const far = Math.max(radius, Math.hypot(dx, dy));
  return { right: dx / far, up: negate(dy / far) };
}

/** The lean without the ways that command nothing. */
export function maskLean({ right, up }: Lean, ways: readonly Arrow[]): Lean {
  const may = (lean: number, high: Arrow, low: Arrow): number =>
    (lean > 0 && !ways.includes(high)) || (lean < 0 && !ways.includes(low)) ? 0 : lean;
  return { right: may(right, "right", "left"), up: may(up, "up", "down") };
}

/** The lean of arrows that are held; those of two axes share it. */
export function combineArrows(ways: Iterable<Arrow>): Lean {
  const held = new Set(ways);
  const right = Number(held.has("right")) - Number(held.has("left"));
  const up = Number(held.has("up")) - Number(held.has("down"));
  const far = Math.max(1, Math.hypot(right, up));
  return { right: right / far, up: up / far };
}

export interface PadState {
  lean: Lean;
  held: number[];
  start: boolean;
}

/** What a gamepad says: its left stick or directional pad, and its buttons. */
export function readGamepad({ axes, buttons }: Pick<Gamepad, "axes" | "buttons">): PadState {
  const pressed = new Set(listPressed(buttons));
  const cross = combineArrows([...pressed].flatMap((index) => PADS[index] ?? []));
  const [x = 0, y = 0] = axes;
  const far = Math.max(1, Math.hypot(x, y));
  const stick = Math.hypot(x, y) <= LOOSE ? REST : { right: x / far, up: negate(y / far) };
  return {
    lean: rests(cross) ? stick : cross,
    held: PAD_HOLDS.flatMap((button, index) => (pressed.has(button) ? [index] : [])),
    start: pressed.has(PAD_START),
  };
}

export function rests({ right, up }: Lean): boolean {
  return right === 0 && up === 0;
}

function negate(y: number): number {
  return y === 0 ? 0 : -y;
}

/** Everything that moves the stick. */
export class Stick {
  /** Where the pointer holds it; null while it does not. */
  pulled: Lean | null = null;
  /** Which buttons on the page are held. */
  readonly pushed = new Set<number>();
  pad: PadState | null = null;
  private readonly arrows = new Map<string, Arrow>();
  private readonly keys = new Set<string>();

  get lean(): Lean {
    if (this.pulled !== null) return this.pulled;
    if (this.pad !== null && !rests(this.pad.lean)) return this.pad.lean;
    return combineArrows(this.arrows.values());
  }

  /** Which of a number of behaviors are held. */
  listHeld(count: number): number[] {
    const pressed = new Set([...this.pushed, ...(this.pad?.held ?? [])]);
    for (const key of this.keys) pressed.add(HOLDS.indexOf(key));
    return [...pressed].filter((index) => index >= 0 && index < count).sort((one, other) => one - other);
  }

  /** A key is pressed; whether it is one of the stick's. */
  press(event: Key): boolean {
    const [way, place] = [ARROWS[event.key], keyboard.place(event)];
    if (way !== undefined) this.arrows.set(event.key, way);
    else if (HOLDS.includes(place)) this.keys.add(place);
    else return false;
    return true;
  }

  lift(event: Key): void {
    this.arrows.delete(event.key);
    this.keys.delete(keyboard.place(event));
  }

  /** Everything is let go of. */
  release(): void {
    this.pulled = null;
    this.pad = null;
    this.pushed.clear();
    this.arrows.clear();
    this.keys.clear();
  }
}
