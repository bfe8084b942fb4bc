/** What tests of drawing share: frames, a browser whose screen frames come when told, and a canvas that counts drawings. */

import { vi } from "vitest";
import { NONE, type Frame } from "../src/frame";
import { News } from "../src/news";
import type { Scene } from "../src/protocol";
import { Motion } from "../src/world/motion";
import type { WorldSource } from "../src/world/stage";

/** A frame of two robots, food and a home, at a time; the second robot is at `x`. */
export function frameAt(time: number, x = 2, more: Partial<Frame> = {}): Frame {
  return {
    paused: false,
    testing: false,
    open: true,
    time,
    tick: Math.round(10 * time),
    state: 0,
    agent: 1,
    robots: {
      count: 2,
      x: new Float32Array([1, x]),
      y: new Float32Array([1, 2]),
      heading: new Float32Array([0, 1]),
      stored: new Uint16Array([0, 1]),
      doing: new Uint16Array([NONE, 0]),
    },
    things: {
      count: 2,
      slot: new Uint16Array([0, 1]),
      kind: new Uint16Array([0, 1]),
      x: new Float32Array([4, 5]),
      y: new Float32Array([4, 5]),
      amount: new Uint16Array([3, 0]),
      atFirst: new Uint16Array([4, 0]),
    },
    features: new Float32Array([3, 0.5, NaN]),
    sonars: new Float32Array([1, NaN]),
    delivered: 0,
    ...more,
  };
}

export const SCENE = {
  drawing: "map",
  width: 10,
  height: 8,
  robots: 2,
  types: [{ radius: 0.2, color: "red" }],
  robot_type: [0, 0],
  classes: [
    { name: "food", food: true, home: false, radius: 0.1, color: null },
    { name: "home", food: false, home: true, radius: 0.3, color: "blue" },
  ],
  walls: [[0, 0, 1, 1]],
  polygons: [],
  discs: [{ x: 3, y: 3, radius: 0.4, color: null }],
  sonars: [[{ from_deg: -10, to_deg: 10, range: 2 }]],
  cameras: [[]],
} as unknown as Scene;

export interface MadeWorld extends WorldSource {
  motion: Motion;
  scene: Scene | null;
  session: WorldSource["session"];
  sort: string | null;
  image: ImageBitmap | null;
  hasControl: boolean;
  live: { fixed: boolean };
}

export function makeWorld(): MadeWorld {
  return {
    news: new News(),
    framed: new News(),
    motion: new Motion(),
    scene: SCENE,
    session: makeSession(),
    sort: null,
    image: null,
    hasControl: true,
    live: { fixed: false },
  };
}

/** What the server says of a session, told anew: equal, and not the same. */
export function makeSession(change: object = {}): NonNullable<WorldSource["session"]> {
  const features = ["distance_to(home)", "angle_to(home)", "speed"].map((label) => ({ label }));
  return { mode: "training", features, activities: ["idle"], ...change } as unknown as NonNullable<
    WorldSource["session"]
  >;
}

/** A browser without a page: its clock, its screen frames and whether it is hidden are what a test says. */
export class Browser {
  readonly document = Object.assign(new EventTarget(), { hidden: false });
  readonly dark = Object.assign(new EventTarget(), { matches: false });
  size = { clientWidth: 640, clientHeight: 480 };
  /** How often the canvas was drawn. */
  drawings = 0;
  private readonly asked = new Map<number, () => void>();
  private number = 0;
  private resized: () => void = () => undefined;

  constructor() {
    vi.stubGlobal("document", this.document);
    vi.stubGlobal("devicePixelRatio", 2);
    vi.stubGlobal(
      "requestAnimationFrame",
      (draw: () => void) => this.asked.set(++this.number, draw) && this.number,
    );
    vi.stubGlobal("cancelAnimationFrame", (number: number) => this.asked.delete(number));
    vi.stubGlobal("matchMedia", () => this.dark);
    vi.stubGlobal("getComputedStyle", () => ({ getPropertyValue: () => "#888888" }));
    const listen = (resized: () => void): void => void (this.resized = resized);
    vi.stubGlobal(
      "ResizeObserver",
      class {
        constructor(resized: () => void) {
          listen(resized);
        }
        observe(): void {}
        disconnect(): void {
          listen(() => undefined);
        }
      },
    );
  }

  /** How many requests wait for the next screen frame. */
  get requests(): number {
    return this.asked.size;
  }

  /** So many screen frames; none comes while the page is hidden. */
  refresh(times = 1): void {
    for (let count = 0; count < times && !this.document.hidden; count += 1) this.refreshOnce();
  }

  /** A screen frame, also where the page was hidden a moment ago. */
  refreshOnce(): void {
    const due = [...this.asked.values()];
    this.asked.clear();
    for (const draw of due) draw();
  }

  hide(hidden: boolean): void {
    this.document.hidden = hidden;
    this.document.dispatchEvent(new Event("visibilitychange"));
  }

  resize(clientWidth: number, clientHeight: number): void {
    Object.assign(this.size, { clientWidth, clientHeight });
    this.resized();
  }

  /** A canvas; each drawing on it begins with a transform. */
  canvas(): HTMLCanvasElement {
    const methods: Record<string | symbol, () => void> = { setTransform: () => (this.drawings += 1) };
    const pen = new Proxy({} as Record<string | symbol, unknown>, {
      get: (set, name) => set[name] ?? methods[name] ?? (() => undefined),
    });
    return Object.assign(this.size, {
      width: 300,
      height: 150,
      getContext: () => pen,
    }) as unknown as HTMLCanvasElement;
  }
}
