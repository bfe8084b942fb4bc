/** Where everything is in the last frame, whether that looks different, and where the trained robot was. */

import { isLike, type Frame } from "../frame";

const JUMP_M = 1.2;
/** How far anything moves in a tick, m. */
const FASTEST_M = 0.1;
const TRAIL = 600;

export interface Place {
  x: number;
  y: number;
}

export interface Pose extends Place {
  heading: number;
}

export class Motion {
  last: Frame | null = null;
  /** Grows with each frame that looks different from the one before. */
  changes = 0;
  readonly trail: Place[] = [];

  take(frame: Frame): void {
    const { last } = this;
    const continues = last !== null && follows(last, frame);
    if (!continues || !isLike(last, frame)) this.changes += 1;
    if (!continues || last.agent !== frame.agent) this.trail.length = 0;
    this.last = frame;
    // What goes farther in a frame was put there.
    this.follow(frame, Math.max(JUMP_M, FASTEST_M * (continues ? frame.tick - last.tick : 0)));
  }

  pose(robot: number): Pose {
    const { x, y, heading } = (this.last as Frame).robots;
    return { x: x[robot] ?? 0, y: y[robot] ?? 0, heading: heading[robot] ?? 0 };
  }

  private follow(frame: Frame, jump: number): void {
    if (!frame.open || frame.agent >= frame.robots.count) return;
    const { x, y } = this.pose(frame.agent);
    const end = this.trail.at(-1);
    if (end !== undefined) {
      const step = Math.hypot(x - end.x, y - end.y);
      if (step < 0.02) return;
      if (step > jump) this.trail.length = 0;
    }
    this.trail.push({ x, y });
    if (this.trail.length > TRAIL) this.trail.shift();
  }
}

function follows(last: Frame, frame: Frame): boolean {
  return frame.tick >= last.tick && frame.robots.count === last.robots.count;
}
