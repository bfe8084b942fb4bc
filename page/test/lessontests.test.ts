import { expect, test } from "vitest";
import type { Answer, Session, Request } from "../src/protocol";
import { LessonTests, type TestSource } from "../src/lessontests";

function asking(answers: (request: Request) => Partial<Answer>) {
  const said: Request[] = [];
  const desk = { name: "goto", edition: 1 };
  const studio: TestSource = {
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
  const trial = new LessonTests(studio);
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
  const trial = new LessonTests(asking(() => ({ error: "the folder is full" })).studio);
  expect(await trial.save()).toBe(false);
  expect(trial.worse).toBeNull();
});

test("all lessons are tested once, the one in training first", async () => {
  const { studio, said, desk } = asking(() => ({ tested: { name: "some" } as never }));
  const trial = new LessonTests(studio);
  expect(trial.results).toBeNull();
  await trial.test();
  expect(said).toEqual([
    { do: "test", name: "goto" },
    { do: "test", name: "fetch" },
  ]);
  expect([trial.results?.length, trial.testing, trial.fresh]).toEqual([2, null, true]);
  desk.edition = 2;
  expect([trial.results?.length, trial.fresh]).toEqual([2, false]);
});

test("what changed unasked is shown before it is saved, and put away", async () => {
  const changed = { line: "forward no longer raises done", changes: [] };
  const { studio, desk } = asking((request) =>
    request.do === "save" && request.anyway !== true ? { worse: [], changed } : { ok: true },
  );
  const trial = new LessonTests(studio);
  expect(await trial.save()).toBe(false);
  expect([trial.worse, trial.changed]).toEqual([[], changed]);
  trial.dismissWarning();
  expect([trial.worse, trial.changed]).toEqual([null, null]);
  expect(await trial.save()).toBe(false);
  desk.edition = 2;
  expect(trial.changed).toBeNull(); // of another lesson
  expect(await trial.save(true)).toBe(true);
});
