import { expect, test } from "vitest";
import { askedStates } from "../src/calls";
import type { State } from "../src/protocol";

function state(name: string, runs: string | null, flag = false): State {
  return { name, key: "1", arrow: null, flag, runs, automaton: null };
}

const START = state("start", null);
const DONE = state("done", null, true);

test("a behavior chosen in one way gives its state its name", () => {
  expect(askedStates(["goto(station)", "load_food"], [])).toEqual(["goto(station)", "load_food"]);
});

test("one chosen in two ways gives two states, each called as it runs", () => {
  expect(askedStates(["goto(station)", "goto(nearest_food)", "load_food"], [])).toEqual([
    "goto(station)=goto(station)",
    "goto(nearest_food)=goto(nearest_food)",
    "load_food",
  ]);
});

test("states that are there keep their names, and with them their examples", () => {
  const states = [START, state("goto", "goto(station)"), state("left", "turn"), state("right", "turn"), DONE];
  expect(askedStates(["goto(station)", "turn", "goto(nearest_food)", "halt"], states)).toEqual([
    "goto=goto(station)",
    "left=turn",
    "right=turn",
    "goto(nearest_food)=goto(nearest_food)",
    "halt",
  ]);
});
