import { expect, test } from "vitest";
import type { LabelSpan, LearnedDrive, Review } from "../src/protocol";
import { around, filesIn, turns } from "../src/recording/recording";
import { color, lines, marks } from "../src/recording/scale";
import { differences, moveBoundary } from "../src/recording/timeline";

function span(first: number, end: number, label: number): LabelSpan {
  return { first, end, label, certainty: 1, doubtful: false, by_hand: false };
}

/** Forward, back, none, forward, in ten ticks each. */
function review(learned: LearnedDrive | null = null): Review {
  return {
    name: "driven",
    tick_s: 0.1,
    labels: ["forward", "back", "unexplained"],
    episodes: [{ source: "drive.csv", driver: "", first: 0, end: 40, from_s: 3 }],
    drivers: [""],
    trust: null,
    spans: [span(0, 10, 0), span(10, 20, 1), span(20, 30, 2), span(30, 40, 0)],
    questions: [],
    proposals: [],
    omissions: [],
    learned,
    can_undo: false,
    saved: null,
  };
}

function learned(...spans: [number, number, number][]): LearnedDrive {
  return {
    agreement: 1,
    repeats: "",
    unseen: 1,
    repeats_unseen: "",
    spans: spans.map(([first, end, label]) => ({ first, end, label })),
    states: [],
    edges: [],
    examples: 0,
    quarantined: 0,
    reactions: [],
    splits: [],
    contradictions: [],
  };
}

test("a boundary that is moved gives the ticks between to the span that grows", () => {
  expect(moveBoundary(review(), 10, 7)).toEqual({ do: "label", first: 7, end: 10, label: "back" });
  expect(moveBoundary(review(), 10, 14)).toEqual({ do: "label", first: 10, end: 14, label: "forward" });
  expect(moveBoundary(review(), 20, 15)).toEqual({ do: "label", first: 15, end: 20, label: "unexplained" });
  expect(moveBoundary(review(), 10, 10)).toBeNull();
});

test("an automaton differs where it is in another state, but not where nothing is known", () => {
  expect(differences(review())).toEqual([]);
  expect(differences(review(learned([0, 12, 0], [12, 25, 1], [25, 40, 0])))).toEqual([
    { first: 10, end: 12 },
  ]);
  expect(differences(review(learned([0, 40, -1])))).toEqual([
    { first: 0, end: 20 },
    { first: 30, end: 40 },
  ]);
});

test("lines end where a value is absent, and where an angle goes around", () => {
  const ticks = [0, 1, 2, 3];
  expect(lines({ ticks, values: [0, 1, null, 2] }, 0, 2)).toEqual(["0,1.0000 1,0.5000", "3,0.0000"]);
  expect(lines({ ticks, values: [0, 6, 6.2, 0.1], period: 6.28 }, 0, 6.28)).toHaveLength(3);
});

test("marks of time are at round times of the file, and have room", () => {
  const [episode] = review().episodes;
  if (episode === undefined) throw new Error("no episode");
  expect(marks(episode, 0.1, 10).map(({ tick, time }) => [tick, time])).toEqual([
    [0, 3],
    [10, 4],
    [20, 5],
    [30, 6],
  ]);
  expect(marks(episode, 0.1, 2)).toEqual([{ tick: 20, time: 5 }]);
});

test("what nothing explains has no color of its own", () => {
  expect(color(2, 3)).toBe(color(-1, 3));
  expect(color(0, 3)).not.toBe(color(1, 3));
});

/** Two files of Anna's, of which the second has a gap, and one of Ben's. */
const DRIVES: Pick<Review, "episodes" | "tick_s"> = {
  tick_s: 0.1,
  episodes: [
    { source: "one.csv", driver: "anna", first: 0, end: 30, from_s: 0 },
    { source: "two.csv", driver: "anna", first: 30, end: 50, from_s: 0 },
    { source: "two.csv", driver: "anna", first: 50, end: 60, from_s: 4 },
    { source: "ben.csv", driver: "ben", first: 60, end: 100, from_s: 0 },
  ],
};

test("drivers take turns, each with the files that they drove", () => {
  expect(turns(DRIVES)).toEqual([
    { driver: "anna", first: 0, end: 60 },
    { driver: "ben", first: 60, end: 100 },
  ]);
  expect(filesIn(DRIVES, { first: 0, end: 60 })).toEqual(["one.csv", "two.csv"]);
  expect(filesIn(DRIVES, { first: 60, end: 100 })).toEqual(["ben.csv"]);
});

test("what is around a tick ends with its episode", () => {
  expect(around(DRIVES, 20)).toEqual({ first: 15, end: 25 });
  expect(around(DRIVES, 31)).toEqual({ first: 30, end: 36 });
  expect(around(DRIVES, 99)).toEqual({ first: 94, end: 100 });
});
