/** A hundred new worlds side by side: the runs of what is trained, how they are laid out, and how far they are shown. */

import { News } from "./news";
import type { Answer, GridWorld, Request, WorldGrid } from "./protocol";

/** How long the runs take on the screen, however long they took in the worlds, ms. */
export const SHOWN_MS = 5000;
const GAP_PX = 3;

export interface Cell {
  left: number;
  top: number;
  width: number;
  height: number;
}

/** What one can tell of a world at a moment of the show. */
export type Outcome = "running" | "works" | "fails";

export class WorldGridRuns {
  readonly news = new News();
  grid: WorldGrid | null = null;
  open = false;
  /** Whether the worlds are being run. */
  running = false;
  /** When the show began, by the page's clock, ms. */
  began = 0;
  /** The world to which the page is going. */
  going: number | null = null;

  constructor(
    private readonly studio: { ask: (request: Request) => Promise<Answer> },
    private readonly clock: () => number = () => performance.now(),
  ) {}

  /** Run what is trained in all worlds as it stands now, and show it. */
  async run(): Promise<void> {
    if (this.running) return;
    this.running = true;
    this.news.tell();
    const { error } = await this.studio.ask({ do: "run_world_grid" });
    const { grid } = error === undefined ? await this.studio.ask({ do: "read_world_grid" }) : {};
    this.running = false;
    if (grid !== undefined) {
      this.grid = grid;
      this.open = true;
      this.began = this.clock();
    }
    this.news.tell();
  }

  /** Go to where it goes wrong in a world, which closes the view. */
  async visit(seed: number): Promise<void> {
    this.going = seed;
    this.news.tell();
    const { error } = await this.studio.ask({ do: "visit_grid_world", seed });
    this.going = null;
    if (error === undefined) this.open = false;
    this.news.tell();
  }

  close(): void {
    this.open = false;
    this.news.tell();
  }

  /** How much of the show has passed, 0 to 1. */
  get progress(): number {
    return Math.min(1, Math.max(0, (this.clock() - this.began) / SHOWN_MS));
  }
}

/** The time in the worlds at a share of the show, s: all have ended at its end. */
export function findTime(grid: WorldGrid, progress: number): number {
  return progress * Math.max(0, ...grid.worlds.map(({ end_s }) => end_s));
}

export function findOutcome(world: GridWorld, time: number): Outcome {
  if (time < world.end_s - 1e-9) return "running";
  return world.works ? "works" : "fails";
}

/** Where a robot is at a time: between two of the places where it was. */
export function findPlace(
  times: readonly number[],
  path: readonly number[],
  time: number,
): readonly [number, number] {
  const last = path.length / 2 - 1;
  const after = times.findIndex((each) => each > time);
  const before = after === -1 ? last : Math.min(after - 1, last);
  const at = (index: number): readonly [number, number] => [path[2 * index] ?? 0, path[2 * index + 1] ?? 0];
  if (before >= last) return at(last);
  const [from, to] = [times[before] ?? 0, times[before + 1] ?? 0];
  const share = to > from ? (time - from) / (to - from) : 1;
  const [[x0, y0], [x1, y1]] = [at(before), at(before + 1)];
  return [x0 + share * (x1 - x0), y0 + share * (y1 - y0)];
}

/** Lay out so many worlds of this shape in a field as large as possible; the rows are centered. */
export function layOut(
  count: number,
  shape: { width: number; height: number },
  field: { width: number; height: number },
): Cell[] {
  let best = { columns: 1, width: 0, height: 0 };
  for (let columns = 1; columns <= count; columns += 1) {
    const rows = Math.ceil(count / columns);
    const room = {
      width: (field.width - GAP_PX * (columns - 1)) / columns,
      height: (field.height - GAP_PX * (rows - 1)) / rows,
    };
    const scale = Math.min(room.width / shape.width, room.height / shape.height);
    const [width, height] = [scale * shape.width, scale * shape.height];
    if (width > best.width) best = { columns, width, height };
  }
  const { columns, width, height } = best;
  const rows = Math.ceil(count / columns);
  const left = (field.width - columns * width - GAP_PX * (columns - 1)) / 2;
  const top = (field.height - rows * height - GAP_PX * (rows - 1)) / 2;
  return Array.from({ length: count }, (_, index) => ({
    left: left + (index % columns) * (width + GAP_PX),
    top: top + Math.floor(index / columns) * (height + GAP_PX),
    width,
    height,
  }));
}
