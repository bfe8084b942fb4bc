import { expect, test } from "vitest";
import { KEPT_S, RunHistory } from "../src/runhistory";
import type { Example } from "../src/protocol";

function example(number: number, more: Partial<Example> = {}): Example {
  const plain = { number, state: "a", next: "b", values: [], kind: "directive", correction: false };
  return { ...plain, time_s: null, contradicts: false, ...more } as Example;
}

test("a run goes on, back, and on from there", () => {
  const past = new RunHistory();
  past.begin(0);
  for (const time of [0, 1, 2, 3]) past.record(time);
  past.markExamples([example(1)], true);
  past.record(4);
  past.record(2);
  expect([past.from, past.now, past.latest]).toEqual([0, 2, 4]);
  expect(past.marks.map((mark) => mark.time)).toEqual([3]);
  past.record(2.1);
  expect([past.now, past.latest]).toEqual([2.1, 2.1]);
  expect(past.marks).toEqual([]);
});

test("marks are for presses that were just shown, and go with their examples", () => {
  const past = new RunHistory();
  past.begin(0);
  past.markExamples([example(1)], false);
  past.record(5);
  const two = example(2, { correction: true });
  past.markExamples([example(1), two, example(3, { kind: "default" })], true);
  expect(past.marks).toEqual([{ number: 2, time: 5, correction: true }]);
  past.markExamples([example(1)], false);
  expect(past.marks).toEqual([]);
});

test("what is too long ago is not offered, and another run begins anew", () => {
  const past = new RunHistory();
  past.begin(0);
  past.record(KEPT_S + 50);
  expect(past.from).toBe(50);
  past.begin(7);
  expect([past.from, past.now, past.latest]).toEqual([7, 7, 7]);
});
