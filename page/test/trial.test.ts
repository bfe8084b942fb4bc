import { expect, test } from "vitest";
import type { Answer, Session, Request } from "../src/protocol";
import { Trial, type Asking } from "../src/trial";

function asking(answers: (request: Request) => Partial<Answer>) {
  const said: Request[] = [];
  const desk = { name: "goto", edition: 1 };
  const studio: Asking = {
    ask: (request) => {
      said.push(request);
      return Promise.resolve({ re: 0, ...answers(request) });
    },
    desk: desk as Session,
    testable: ["fetch", "goto"],
    news: { tell: () => undefined },
  };
  return { studio, said, desk };
}

test("what saving would break is known until the lesson changes, or it is saved anyway", async () => {
  const { studio, said, desk } = asking((request) =>
    request.do === "save" && request.anyway !== true ? { worse: ["it no longer turns"] } : { ok: true },
  );
  const trial = new Trial(studio);
  expect(await trial.save()).toBe(false);
  expect(trial.worse).toEqual(["it no longer turns"]);
  desk.edition = 2;
  expect(trial.worse).toBeNull();
  expect(await trial.save()).toBe(false);
  expect(await trial.save(true)).toBe(true);
  expect(trial.worse).toBeNull();
  expect(said.at(-1)).toEqual({ do: "save", name: null, anyway: true });
});

test("what could not be saved is not saved", async () => {
  const trial = new Trial(asking(() => ({ error: "the folder is full" })).studio);
  expect(await trial.save()).toBe(false);
  expect(trial.worse).toBeNull();
});

test("all lessons are tested once, the one in training first", async () => {
  const { studio, said, desk } = asking(() => ({ tested: { name: "some" } as never }));
  const trial = new Trial(studio);
  expect(trial.found).toBeNull();
  await trial.test();
  expect(said).toEqual([
    { do: "test", name: "goto" },
    { do: "test", name: "fetch" },
  ]);
  expect([trial.found?.length, trial.testing, trial.fresh]).toEqual([2, null, true]);
  desk.edition = 2;
  expect([trial.found?.length, trial.fresh]).toEqual([2, false]);
});

test("what changed unasked is shown before it is saved, and put away", async () => {
  const changed = { line: "forward no longer raises done", changes: [] };
  const { studio, desk } = asking((request) =>
    request.do === "save" && request.anyway !== true ? { worse: [], changed } : { ok: true },
  );
  const trial = new Trial(studio);
  expect(await trial.save()).toBe(false);
  expect([trial.worse, trial.changed]).toEqual([[], changed]);
  trial.leave();
  expect([trial.worse, trial.changed]).toEqual([null, null]);
  expect(await trial.save()).toBe(false);
  desk.edition = 2;
  expect(trial.changed).toBeNull(); // of another lesson
  expect(await trial.save(true)).toBe(true);
});
