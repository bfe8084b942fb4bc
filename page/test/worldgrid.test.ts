import { expect, test } from "vitest";
import type { GridWorld, Request, WorldGrid } from "../src/protocol";
import { findOutcome, findPlace, findTime, layOut, SHOWN_MS, WorldGridRuns } from "../src/worldgrid";

function world(seed: number, works: boolean, end_s: number): GridWorld {
  return { seed, works, was_shown: false, end_s, paths: [[0, 0, 2, 0]], things: [], lines: [], discs: [] };
}

const GRID: WorldGrid = {
  name: "goto",
  width: 10,
  height: 5,
  robot_radius: 0.2,
  times: [0, 1, 2, 4],
  works: 1,
  success: "done",
  worlds: [world(5, true, 2), world(6, false, 4)],
};

test("a world is green or red from its end on, and all have ended at the end of the show", () => {
  const [first, second] = GRID.worlds as [GridWorld, GridWorld];
  expect([0, 0.5, 1].map((share) => findTime(GRID, share))).toEqual([0, 2, 4]);
  expect([0, 1.9, 2, 4].map((time) => findOutcome(first, time))).toEqual([
    "running",
    "running",
    "works",
    "works",
  ]);
  expect([3.9, 4].map((time) => findOutcome(second, time))).toEqual(["running", "fails"]);
});

test("a robot is between the places where it was, and stays where its path ends", () => {
  const path = [0, 0, 2, 0, 2, 4];
  const seen: [number, [number, number]][] = [
    [0, [0, 0]],
    [0.5, [1, 0]],
    [1, [2, 0]],
    [1.25, [2, 1]],
    [2, [2, 4]],
    [9, [2, 4]],
  ];
  for (const [time, place] of seen) expect(findPlace(GRID.times, path, time), `at ${time}`).toEqual(place);
});

test.each([
  [100, { width: 10, height: 10 }, { width: 600, height: 600 }, 10],
  [100, { width: 20, height: 10 }, { width: 600, height: 600 }, 7],
  [100, { width: 10, height: 10 }, { width: 360, height: 700 }, 7],
  [1, { width: 10, height: 5 }, { width: 300, height: 300 }, 1],
])("%d worlds are as large as fits, and none lies outside", (count, shape, field, columns) => {
  const cells = layOut(count, shape, field);
  expect(cells).toHaveLength(count);
  expect(new Set(cells.map(({ left }) => left)).size).toBe(columns);
  for (const { left, top, width, height } of cells) {
    expect(Math.min(left, top)).toBeGreaterThanOrEqual(-1e-6);
    expect(left + width).toBeLessThanOrEqual(field.width + 1e-6);
    expect(top + height).toBeLessThanOrEqual(field.height + 1e-6);
    expect(width / height).toBeCloseTo(shape.width / shape.height);
  }
});

test("the runs are shown from the moment they have come, and going to a world closes them", async () => {
  const asked: Request["do"][] = [];
  let now = 1000;
  const runs = new WorldGridRuns(
    {
      ask: async (request: Request) => {
        asked.push(request.do);
        now += 500;
        return { re: 1, ok: true, ...(request.do === "read_world_grid" ? { grid: GRID } : {}) };
      },
    },
    () => now,
  );
  await runs.run();
  expect(asked).toEqual(["run_world_grid", "read_world_grid"]);
  expect([runs.open, runs.running, runs.progress]).toEqual([true, false, 0]);
  now += SHOWN_MS / 2;
  expect(runs.progress).toBe(0.5);
  now += SHOWN_MS;
  expect(runs.progress).toBe(1);
  await runs.visit(6);
  expect([asked.at(-1), runs.open, runs.going]).toEqual(["visit_grid_world", false, null]);
});

test("where the runs are refused, nothing opens", async () => {
  const runs = new WorldGridRuns({ ask: async () => ({ re: 1, error: "there is nothing to run yet" }) });
  await runs.run();
  expect([runs.open, runs.running, runs.grid]).toEqual([false, false, null]);
});
