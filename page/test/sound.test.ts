import { describe, expect, it } from "vitest";
import { isNewQuestion, soundIsOn } from "../src/sound";

const NOTHING = { question: null, marks: 0 };

describe("the sound of a question", () => {
  it.each([
    ["nothing is asked", NOTHING, NOTHING, false],
    ["a question waits", { question: "left?", marks: 0 }, NOTHING, true],
    ["the same question waits", { question: "left?", marks: 0 }, { question: "left?", marks: 0 }, false],
    ["another question waits", { question: "right?", marks: 0 }, { question: "left?", marks: 0 }, true],
    ["it was answered", NOTHING, { question: "left?", marks: 0 }, false],
    ["a moment was marked", { question: null, marks: 2 }, { question: null, marks: 1 }, true],
    ["a mark is gone", { question: null, marks: 1 }, { question: null, marks: 2 }, false],
  ])("%s", (_, now, before, heard) => {
    expect(isNewQuestion(now, before)).toBe(heard);
  });

  it("is off until it is switched on", () => {
    expect(soundIsOn({ getItem: () => null })).toBe(false);
    expect(soundIsOn({ getItem: () => "on" })).toBe(true);
  });
});
