/**
 * The first-run tour: six steps, each done by what the person really does; ends with a robot that goes by itself in a
 * hundred worlds.
 */

import { News } from "./news";

export const STEPS = ["Begin", "Turn", "Drive", "Once more", "By itself", "Everywhere"] as const;
/** After so many worlds the tour goes on, also with a robot that still needed a press in each. */
export const MOST_WORLDS = 6;
export const NEAR_M = 0.35;
/** Nearer than this it counts as there. */
const THERE_M = 1;
/** A is ahead: where it may stop turning, which a late press still meets, and where it may go on driving. */
const TURNED_DEG = 20;
const AHEAD_DEG = 40;
/** The angle past A from which on a robot should turn back. */
const PAST_DEG = 90;
/**
 * The time for which a robot that decides by itself may be wrong before the tour speaks, and for which it must then be
 * right before the tour goes on, s of the world's time; a robot that turns to and fro is never right for this time.
 */
export const PATIENCE_S = 0.5;
const KEPT = "understudy-tour";

/** What the tour looks at. */
export interface Moment {
  /** Whether what the tour teaches is in training. */
  isTaught: boolean;
  /** The state that is lit. */
  state: string;
  /** Whether it is a flag: the robot has stopped, and says so. */
  stopped: boolean;
  /** How many presses the lesson has. */
  presses: number;
  seed: number | null;
  /** Where A is: m and degrees, left of ahead above 0; NaN while it is not seen. */
  distance: number;
  angle: number;
  /** In how many of a hundred worlds it worked; null before it was seen there. */
  works: number | null;
}

interface SavedTour {
  step: number;
  active: boolean;
  seed: number | null;
}

export class Tour {
  readonly news = new News();
  /** How many steps are done. */
  step = 0;
  active = false;
  /** The world of the step before: the next one is in another. */
  private seed: number | null = null;
  /** The present world, and how many presses the lesson had when it began. */
  private world: { seed: number | null; presses: number } | null = null;
  /** How many worlds there were since the tour began. */
  private worlds = 0;

  /** The time since which the robot is wrong, without being right for PATIENCE_S since, s of the world's time. */
  private wrongSince: number | null = null;
  /** The time since which the robot does the right thing. */
  private rightSince: number | null = null;

  constructor(private readonly store: Pick<Storage, "getItem" | "setItem">) {
    Object.assign(this, read(store));
  }

  get done(): boolean {
    return this.step >= STEPS.length;
  }

  /** Whether it was left on the way. */
  get left(): boolean {
    return !this.active && this.step > 0 && !this.done;
  }

  /** Take it up: from the beginning, or where it was left. */
  begin(restart: boolean): void {
    if (restart) this.step = this.worlds = 0;
    this.active = true;
    this.keep();
  }

  leave(): void {
    this.active = false;
    this.keep();
  }

  see(moment: Moment): void {
    if (!this.active || this.done || !this.finishes(moment)) return;
    this.step += 1;
    this.seed = moment.seed;
    this.keep();
  }

  /** Whether the world of the step before is still there. */
  same({ seed }: Moment): boolean {
    return seed === this.seed;
  }

  /** Whether there was no press in this world so far. */
  alone({ presses }: Moment): boolean {
    return this.world !== null && this.world.presses === presses;
  }

  /** Whether the robot does something else than it should, and has for so long that it needs help. */
  needsHelp(wrong: boolean, time: number): boolean {
    if (this.wrongSince !== null && time < this.wrongSince) this.wrongSince = null;
    this.rightSince = wrong ? null : Math.min(this.rightSince ?? time, time);
    if (wrong) this.wrongSince ??= time;
    else if (hasLasted(this.rightSince, time)) this.wrongSince = null;
    return wrong && hasLasted(this.wrongSince, time);
  }

  private finishes(moment: Moment): boolean {
    const { isTaught, seed, presses, angle } = moment;
    if (this.world?.seed !== seed) this.worlds += 1;
    if (this.world === null || this.world.seed !== seed || presses < this.world.presses)
      this.world = { seed, presses };
    if (this.step === 0 || !isTaught) return isTaught && this.step === 0;
    const stopped = isThere(moment);
    if (this.step === 1) return stopped || (presses > 0 && Math.abs(angle) < TURNED_DEG);
    if (this.step === 2) return stopped;
    if (this.step === 5) return moment.works !== null;
    const isEnough = this.step === 3 || this.alone(moment) || this.worlds >= MOST_WORLDS;
    return stopped && !this.same(moment) && isEnough;
  }

  private keep(): void {
    const saved: SavedTour = { step: this.step, active: this.active, seed: this.seed };
    this.store.setItem(KEPT, JSON.stringify(saved));
    this.news.tell();
  }
}

/** Whether it lasts long enough for the tour to say so. */
function hasLasted(since: number | null, time: number): boolean {
  return since !== null && time - since >= PATIENCE_S - 1e-6;
}

/** Whether the robot has stopped near A. */
export function isThere({ stopped, distance }: Moment): boolean {
  return stopped && !(distance > THERE_M);
}

/** Which way the robot should go: its arrow, or "done" where it is there; null while A is not seen. */
export function chooseDirection(
  { distance, angle }: Moment,
  now: string | null,
): "up" | "left" | "right" | "done" | null {
  if (Number.isNaN(distance) || Number.isNaN(angle)) return null;
  if (distance < NEAR_M) return "done";
  const off = Math.abs(angle);
  if (off < (now === "up" ? AHEAD_DEG : TURNED_DEG)) return "up";
  if ((now === "left" || now === "right") && off > PAST_DEG) return now;
  return angle > 0 ? "left" : "right";
}

function read(store: Pick<Storage, "getItem">): Partial<SavedTour> {
  try {
    const { step, active, seed } = JSON.parse(store.getItem(KEPT) ?? "{}") as Partial<SavedTour>;
    return typeof step === "number" && typeof active === "boolean"
      ? { step, active, seed: seed ?? null }
      : {};
  } catch {
    return {};
  }
}
