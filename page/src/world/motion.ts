/** Where everything is between two frames, so that 10 ticks a second look smooth, and where the trained robot was. */

import type { Frame } from "../frame";
import { turned } from "./geometry";

const LONGEST_GAP = 260;
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
  readonly trail: Place[] = [];
  private former: Frame | null = null;
  private arrived = 0;
  private gap = 100;
  /** What is farther apart in the two frames was put there: m. */
  private jump = JUMP_M;

  take(frame: Frame, now: number): void {
    const last = this.last;
    const continues = last !== null && follows(last, frame);
    if (last !== null && continues && frame.tick > last.tick) {
      const gap = Math.min(now - this.arrived, LONGEST_GAP);
      this.gap += (gap - this.gap) * 0.2;
    }
    this.jump = Math.max(JUMP_M, FASTEST_M * (continues ? frame.tick - last.tick : 0));
    this.former = continues ? last : null;
    if (!continues || last.agent !== frame.agent) this.trail.length = 0;
    this.last = frame;
    this.arrived = now;
    this.follow(frame);
  }

  /** How far the picture is from the former frame to the last one, 0 to 1. */
  share(now: number): number {
    return Math.min((now - this.arrived) / this.gap, 1);
  }

  pose(robot: number, share: number): Pose {
    const { robots } = this.last as Frame;
    const x = robots.x[robot] ?? 0;
    const y = robots.y[robot] ?? 0;
    const heading = robots.heading[robot] ?? 0;
    const before = this.former?.robots;
    if (before === undefined || share >= 1) return { x, y, heading };
    const fromX = before.x[robot] ?? x;
    const fromY = before.y[robot] ?? y;
    if (Math.hypot(x - fromX, y - fromY) > this.jump) return { x, y, heading };
    const from = before.heading[robot] ?? heading;
    return {
      x: fromX + (x - fromX) * share,
      y: fromY + (y - fromY) * share,
      heading: from + turned(from, heading) * share,
    };
  }

  /** Objects keep their slots, and mostly their places in the frame too. */
  place(thing: number, share: number): Place {
    const { things } = this.last as Frame;
    const x = things.x[thing] ?? 0;
    const y = things.y[thing] ?? 0;
    const before = this.former?.things;
    if (before === undefined || share >= 1 || before.slot[thing] !== things.slot[thing]) return { x, y };
    const fromX = before.x[thing] ?? x;
    const fromY = before.y[thing] ?? y;
    if (Math.hypot(x - fromX, y - fromY) > this.jump) return { x, y };
    return { x: fromX + (x - fromX) * share, y: fromY + (y - fromY) * share };
  }

  private follow(frame: Frame): void {
    if (!frame.open || frame.agent >= frame.robots.count) return;
    const at = { x: frame.robots.x[frame.agent] ?? 0, y: frame.robots.y[frame.agent] ?? 0 };
    const end = this.trail.at(-1);
    if (end !== undefined) {
      const step = Math.hypot(at.x - end.x, at.y - end.y);
      if (step < 0.02) return;
      if (step > this.jump) this.trail.length = 0;
    }
    this.trail.push(at);
    if (this.trail.length > TRAIL) this.trail.shift();
  }
}

function follows(last: Frame, frame: Frame): boolean {
  return frame.tick >= last.tick && frame.robots.count === last.robots.count;
}
