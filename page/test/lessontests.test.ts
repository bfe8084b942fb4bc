import { expect, test } from "vitest";
import type { Answer, Session, Request } from "../src/protocol";
import { LessonTests, type TestSource } from "../src/lessontests";

function makeSource(answers: (request: Request) => Partial<Answer>) {
  const requests: Request[] = [];
  const session = { name: "goto", edition: 1 };
  const studio: TestSource = {
    ask: (request) => {
      requests.push(request);
      return Promise.resolve({ re: 0, ...answers(request) });
    },
    session: session as Session,
    testable: ["fetch", "goto"],
    news: { tell: () => undefined },
  };
  return { studio, requests, session };
}

test("what saving would break is known until the lesson changes, or it is saved anyway", async () => {
  const { studio, requests, session } = makeSource((request) =>
    request.do === "save" && request.anyway !== true ? { regressions: ["it no longer turns"] } : { ok: true },
  );
  const tests = new LessonTests(studio);
  expect(await tests.save()).toBe(false);
  expect(tests.regressions).toEqual(["it no longer turns"]);
  session.edition = 2;
  expect(tests.regressions).toBeNull();
  expect(await tests.save()).toBe(false);
  expect(await tests.save(true)).toBe(true);
  expect(tests.regressions).toBeNull();
  expect(requests.at(-1)).toEqual({ do: "save", name: null, anyway: true });
});

test("what could not be saved is not saved", async () => {
  const tests = new LessonTests(makeSource(() => ({ error: "the folder is full" })).studio);
  expect(await tests.save()).toBe(false);
  expect(tests.regressions).toBeNull();
});

test("all lessons are tested once, the one in training first", async () => {
  const { studio, requests, session } = makeSource(() => ({ test: { name: "some" } as never }));
  const tests = new LessonTests(studio);
  expect(tests.results).toBeNull();
  await tests.test();
  expect(requests).toEqual([
    { do: "test", name: "goto" },
    { do: "test", name: "fetch" },
  ]);
  expect([tests.results?.length, tests.testing, tests.fresh]).toEqual([2, null, true]);
  session.edition = 2;
  expect([tests.results?.length, tests.fresh]).toEqual([2, false]);
});

test("what changed unasked is shown before it is saved, and put away", async () => {
  const changed = { line: "forward no longer raises done", changes: [] };
  const { studio, session } = makeSource((request) =>
    request.do === "save" && request.anyway !== true ? { regressions: [], changed } : { ok: true },
  );
  const tests = new LessonTests(studio);
  expect(await tests.save()).toBe(false);
  expect([tests.regressions, tests.changed]).toEqual([[], changed]);
  tests.dismissWarning();
  expect([tests.regressions, tests.changed]).toEqual([null, null]);
  expect(await tests.save()).toBe(false);
  session.edition = 2;
  expect(tests.changed).toBeNull(); // of another lesson
  expect(await tests.save(true)).toBe(true);
});
