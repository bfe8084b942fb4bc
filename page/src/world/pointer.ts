/** The pointer on the world: pan, pinch and zoom; drag and turn robots, drag objects; click to choose or to place. */

import { toWorld } from "./geometry";
import { listenTo } from "../listen";
import { GRASP_PX, type Handle } from "./handle";
import type { Mark } from "./picture";
import type { Stage } from "./stage";
import { extent } from "./things";

/** A press that moves farther is a drag. Fingers are less steady than a mouse, and hide what they press. */
const SLOP_PX = { mouse: 4, touch: 9 };
const REACH_PX = 7;
const LEAST_PX = { mouse: 0, touch: GRASP_PX };
const EVERY_MS = 60;

export interface Click {
  mark: Mark | null;
  /** Where it was clicked, m. */
  x: number;
  y: number;
}

export function listenToPointer(stage: Stage, clicked: (chosen: Click) => void): () => void {
  const drag = new PointerDrag(stage, clicked);
  const wheel = (event: WheelEvent): void => {
    event.preventDefault();
    stage.zoom(Math.exp(-event.deltaY * 0.0016), event.offsetX, event.offsetY);
  };
  const handlers = {
    pointerdown: (event: PointerEvent) => drag.down(event),
    pointermove: (event: PointerEvent) => drag.move(event),
    pointerup: (event: PointerEvent) => drag.up(event),
    pointercancel: (event: PointerEvent) => drag.up(event),
    dblclick: () => stage.fit(),
    wheel,
  };
  return listenTo(stage.canvas, handlers, { passive: false });
}

class PointerDrag {
  private readonly fingers = new Map<number, { x: number; y: number }>();
  private held: Mark | null = null;
  private start = { x: 0, y: 0 };
  private moved = false;
  private turned = false;
  private sent = 0;

  constructor(
    private readonly stage: Stage,
    private readonly clicked: (chosen: Click) => void,
  ) {}

  down(event: PointerEvent): void {
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    if (this.fingers.size > 1) return this.letGo();
    this.start = { x: event.offsetX, y: event.offsetY };
    this.moved = false;
    this.turned = false;
    const handle = handleUnder(this.stage, event);
    this.stage.turning = handle !== null;
    if (handle !== null) this.held = { what: "robot", of: handle.robot };
    else this.held = this.stage.studio.hasControl ? findMark(this.stage, event) : null;
  }

  move(event: PointerEvent): void {
    const { stage } = this;
    const before = this.fingers.get(event.pointerId);
    if (before === undefined) {
      stage.canvas.style.cursor =
        (handleUnder(stage, event) ?? findMark(stage, event)) === null ? "" : "grab";
      return;
    }
    const at = { x: event.offsetX, y: event.offsetY };
    if (this.fingers.size === 2) this.pinch(event.pointerId, before, at);
    this.fingers.set(event.pointerId, at);
    if (this.fingers.size > 1) return;
    if (Math.hypot(at.x - this.start.x, at.y - this.start.y) > SLOP_PX[pointerKind(event)]) this.moved = true;
    if (!this.moved) return;
    if (this.held === null) stage.pan(at.x - before.x, at.y - before.y);
    else if (stage.turning || (event.shiftKey && this.held.what === "robot"))
      this.turn(this.held.of, at.x, at.y);
    else this.drag(this.held, at.x, at.y);
  }

  up(event: PointerEvent): void {
    const { stage } = this;
    if (!this.fingers.delete(event.pointerId) || this.fingers.size > 0) return;
    const [x, y] = toWorld(stage.view, stage.screen, event.offsetX, event.offsetY);
    if (!this.moved && !stage.turning && event.type === "pointerup") {
      this.clicked({ mark: findMark(stage, event), x, y });
    }
    if (this.held !== null && this.turned) this.turn(this.held.of, event.offsetX, event.offsetY);
    if (this.held !== null && this.moved && !this.turned)
      void this.place(this.held, x, y).then(() => this.letGo());
    else this.letGo();
  }

  private letGo(): void {
    this.held = null;
    this.stage.dragged = null;
    this.stage.turning = false;
    this.stage.draw();
  }

  private drag(held: Mark, px: number, py: number): void {
    const { stage } = this;
    const [x, y] = toWorld(stage.view, stage.screen, px, py);
    stage.dragged = { ...held, x, y };
    stage.draw();
    if (performance.now() - this.sent > EVERY_MS) void this.place(held, x, y);
  }

  /** A robot stays and turns to the pointer, or away from one that holds the handle behind it. */
  private turn(agent: number, px: number, py: number): void {
    const { stage } = this;
    const last = this.fingers.size === 0;
    this.turned = true;
    if (!last && performance.now() - this.sent < EVERY_MS) return;
    this.sent = performance.now();
    const { x, y } = stage.studio.motion.pose(agent);
    const [toX, toY] = toWorld(stage.view, stage.screen, px, py);
    const side = stage.turning && stage.handle?.behind === true ? -1 : 1;
    const heading = Math.atan2(side * (toY - y), side * (toX - x));
    void stage.studio.ask({ do: "move_robot", agent, x, y, heading });
  }

  private place(held: Mark, x: number, y: number): Promise<unknown> {
    this.sent = performance.now();
    const { studio } = this.stage;
    if (held.what === "robot") return studio.ask({ do: "move_robot", agent: held.of, x, y, heading: null });
    if (held.what === "obstacle") return studio.ask({ do: "move_obstacle", index: held.of, x, y });
    return studio.ask({ do: "move_object", slot: held.of, x, y });
  }

  private pinch(finger: number, before: { x: number; y: number }, at: { x: number; y: number }): void {
    const other = [...this.fingers].find(([id]) => id !== finger)?.[1];
    if (other === undefined) return;
    const far = Math.hypot(at.x - other.x, at.y - other.y);
    const was = Math.max(Math.hypot(before.x - other.x, before.y - other.y), 1);
    this.stage.zoom(far / was, (at.x + other.x) / 2, (at.y + other.y) / 2);
    this.stage.pan((at.x - before.x) / 2, (at.y - before.y) / 2);
    this.moved = true;
  }
}

function pointerKind(event: PointerEvent): "mouse" | "touch" {
  return event.pointerType === "touch" ? "touch" : "mouse";
}

function handleUnder({ handle }: Stage, { offsetX, offsetY }: PointerEvent): Handle | null {
  return handle !== null && Math.hypot(offsetX - handle.x, offsetY - handle.y) <= GRASP_PX ? handle : null;
}

/** The robot, object or round obstacle at a pointer: in this order, the nearest of them. */
function findMark(stage: Stage, event: PointerEvent): Mark | null {
  const { scene, motion } = stage.studio;
  const frame = motion.last;
  if (scene === null || frame === null || scene.drawing !== "map") return null;
  const [x, y] = toWorld(stage.view, stage.screen, event.offsetX, event.offsetY);
  const reach = REACH_PX / stage.view.scale;
  const least = LEAST_PX[pointerKind(event)] / stage.view.scale;
  let nearestMark: Mark | null = null;
  let nearest = Infinity;
  const consider = (mark: Mark, far: number, radius: number): void => {
    if (far > Math.max(radius + reach, least) || far >= nearest) return;
    nearestMark = mark;
    nearest = far;
  };
  const { robots, things } = frame;
  for (let robot = 0; robot < robots.count; robot += 1) {
    const radius = scene.types[scene.robot_type[robot] ?? 0]?.radius ?? 0.2;
    const far = Math.hypot((robots.x[robot] ?? 0) - x, (robots.y[robot] ?? 0) - y);
    consider({ what: "robot", of: robot }, far, radius);
  }
  if (nearestMark !== null) return nearestMark;
  for (let index = 0; index < things.count; index += 1) {
    const kind = scene.classes[things.kind[index] ?? -1];
    if (kind === undefined) continue;
    const far = Math.hypot((things.x[index] ?? 0) - x, (things.y[index] ?? 0) - y);
    consider({ what: "thing", of: things.slot[index] ?? 0 }, far, extent(kind, things.atFirst[index] ?? 0));
  }
  if (nearestMark !== null) return nearestMark;
  scene.discs.forEach(({ x: left, y: up, radius }, index) => {
    if (Math.hypot(left - x, up - y) < radius) nearestMark = { what: "obstacle", of: index };
  });
  return nearestMark;
}
