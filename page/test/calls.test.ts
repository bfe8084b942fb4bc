import { expect, test } from "vitest";
import {
  requestStates,
  chooseState,
  chooseLessonStates,
  offerFeatures,
  duplicateState,
  listRenamed,
  stateNames,
  findDuplicate,
} from "../src/calls";
import type { Session, SessionNews, Scene, State } from "../src/protocol";

function state(name: string, runs: string | null, flag = false): State {
  return { name, key: "1", arrow: null, flag, runs, automaton: null };
}

test("a behavior chosen in one way gives its state its name", () => {
  const states = ["goto(station)", "load_food"].map(chooseState);
  expect(requestStates(states)).toEqual(["goto(station)", "load_food"]);
  expect(stateNames(states)).toEqual(["goto", "load_food"]);
});

test("one chosen in two ways gives two states, each called as it runs", () => {
  expect(requestStates(["goto(station)", "goto(nearest_food)", "load_food"].map(chooseState))).toEqual([
    "goto(station)=goto(station)",
    "goto(nearest_food)=goto(nearest_food)",
    "load_food",
  ]);
});

test("one taken once more gives two states of different names, which can be changed", () => {
  const [first, second, third] = duplicateState(duplicateState([chooseState("forward")], 0), 0);
  if (first === undefined || second === undefined || third === undefined) throw new Error("three");
  expect(stateNames([first, second, third])).toEqual(["forward", "forward_3", "forward_2"]);
  const named = [
    { ...first, name: "forward_left" },
    { ...second, name: " forward_right " },
  ];
  expect(requestStates(named)).toEqual(["forward_left=forward", "forward_right=forward"]);
  expect(findDuplicate(named)).toBeNull();
  expect(findDuplicate([...named, { ...third, name: "forward_left" }])).toBe("forward_left");
});

test("states that are there keep their names, and with them their examples, unless they get others", () => {
  const states = [
    state("start", null),
    state("goto", "goto(station)"),
    state("left", "turn"),
    state("right", "turn"),
    state("done", null, true),
  ];
  const there = chooseLessonStates({ states } as unknown as Session);
  expect(requestStates([...there, chooseState("goto(nearest_food)"), chooseState("halt")])).toEqual([
    "goto(station)",
    "left=turn",
    "right=turn",
    "goto(nearest_food)=goto(nearest_food)",
    "halt",
  ]);
  expect(listRenamed(there)).toEqual({});
  const other = there.map((each) => (each.name === "left" ? { ...each, name: "port" } : each));
  expect(listRenamed(other)).toEqual({ left: "port" });
});

test("flags that trained automata raise are offered beside the kit's features, each once", () => {
  const features = [
    { label: "distance_to(A)", parameters: ["A"], unit: "m" },
    { label: "done", parameters: [], unit: "" },
  ];
  const trained = [{ flags: ["done", "crate_seen"] }, { flags: ["crate_seen"] }];
  const told = { library: { trained } } as unknown as SessionNews;
  const offered = offerFeatures({ features } as unknown as Scene, told, ["home"]);
  expect(offered.flatMap(({ ways }) => ways)).toEqual(["distance_to(home)", "done", "crate_seen"]);
});
