import { expect, test } from "vitest";
import { drawing } from "../src/graph";
import type { State } from "../src/protocol";

function state(name: string, more: Partial<State> = {}): State {
  return { name, key: "1", arrow: null, flag: false, runs: name, ...more };
}

const STATES = [
  state("start"),
  state("forward", { arrow: "up" }),
  state("right", { arrow: "right" }),
  state("left", { arrow: "left" }),
  state("done", { flag: true }),
];

test("before anything is learned, the start state is above and flags are below", () => {
  const y = new Map(drawing(STATES, [], ({ name }) => name).nodes.map((node) => [node.state.name, node.y]));
  expect(y.get("start")).toBeLessThan(y.get("forward") ?? 0);
  expect(y.get("forward")).toBeLessThan(y.get("done") ?? 0);
});

test("turning left is drawn left of turning right", () => {
  const x = new Map(drawing(STATES, [], ({ name }) => name).nodes.map((node) => [node.state.name, node.x]));
  expect(x.get("left")).toBeLessThan(x.get("right") ?? 0);
});

test("every transition between known states is drawn, there and back", () => {
  const edge = { when: ["always"], examples: [1] };
  const edges = [
    { from: "start", to: "forward", ...edge },
    { from: "forward", to: "left", ...edge },
    { from: "left", to: "forward", ...edge },
    { from: "left", to: "gone", ...edge },
  ];
  const arcs = drawing(STATES, edges, ({ name }) => name).arcs;
  expect(arcs.map(({ id }) => id)).toEqual(["start forward", "forward left", "left forward"]);
  expect(arcs.every(({ points }) => points.length > 1)).toBe(true);
});
