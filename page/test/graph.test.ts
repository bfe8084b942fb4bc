import { expect, test } from "vitest";
import { layoutGraph, edgeOf, innerEdge } from "../src/graph";
import type { State } from "../src/protocol";

function state(name: string, more: Partial<State> = {}): State {
  return { name, key: "1", arrow: null, flag: false, runs: name, automaton: null, ...more };
}

const STATES = [
  state("start"),
  state("forward", { arrow: "up" }),
  state("right", { arrow: "right" }),
  state("left", { arrow: "left" }),
  state("done", { flag: true }),
];

test("before anything is learned, the start state is above and flags are below", () => {
  const y = new Map(
    layoutGraph(STATES, [], ({ name }) => name).nodes.map((node) => [node.state.name, node.y]),
  );
  expect(y.get("start")).toBeLessThan(y.get("forward") ?? 0);
  expect(y.get("forward")).toBeLessThan(y.get("done") ?? 0);
});

test("many states stand in rows that can be read side by side", () => {
  const many = ["start", "one", "two", "three", "four", "five", "six"].map((name) => state(`state_${name}`));
  const drawn = layoutGraph([...many, state("done", { flag: true })], [], ({ name }) => name);
  const rows = [...new Set(drawn.nodes.map(({ y }) => y))];
  expect(drawn.width).toBeLessThan(400);
  expect(rows.length).toBe(4);
  expect(drawn.nodes.at(-1)?.y).toBe(Math.max(...rows));
});

test("turning left is drawn left of turning right", () => {
  const x = new Map(
    layoutGraph(STATES, [], ({ name }) => name).nodes.map((node) => [node.state.name, node.x]),
  );
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
  const arcs = layoutGraph(STATES, edges, ({ name }) => name).arcs;
  expect(arcs.map(({ id }) => id)).toEqual(["start forward", "forward left", "left forward"]);
  expect(arcs.every(({ points }) => points.length > 1)).toBe(true);
});

test("a state that runs an automaton opens in place: it is as large as what it shows", () => {
  const states = [state("start"), state("goto", { automaton: "goto" })];
  const nested = { goto: { states: STATES, edges: [{ from: "start", to: "forward", when: ["always"] }] } };
  const name = (each: { name: string }): string => each.name;
  const closed = layoutGraph(states, [], name, new Set(), nested).nodes[1];
  const open = layoutGraph(states, [], name, new Set(["/goto"]), nested).nodes[1];
  expect(closed?.inner).toBeNull();
  expect(open?.inner?.nodes.map(({ path }) => path)).toContain("/goto/forward");
  expect(open?.inner?.arcs.map(({ id }) => id)).toEqual(["/goto\nstart forward"]);
  expect(open?.width).toBeGreaterThan(open?.inner?.width ?? NaN);
  expect(open?.height).toBeGreaterThan(open?.inner?.height ?? NaN);
});

test("an edge of an automaton in an automaton is told from those outside by where it is", () => {
  const edge = { from: "start", to: "forward", when: ["when far"] };
  const nested = {
    goto: { states: [state("start"), state("forward")], edges: [edge] },
    harvest: { states: [state("start"), state("goto", { automaton: "goto" })], edges: [] },
  };
  const states = [
    state("start"),
    state("goto", { automaton: "goto" }),
    state("harvest", { automaton: "harvest" }),
  ];
  const opened = new Set(["/goto", "/harvest", "/harvest/goto"]);
  const drawn = layoutGraph(states, [], ({ name }) => name, opened, nested);
  const near = drawn.nodes[1]?.inner?.arcs[0]?.id ?? "";
  const deep = drawn.nodes[2]?.inner?.nodes[1]?.inner?.arcs[0]?.id ?? "";
  expect(new Set(["start forward", near, deep]).size).toBe(3);
  expect(innerEdge(states, nested, near)).toEqual({ edge, of: "goto" });
  expect(innerEdge(states, nested, deep)).toEqual({ edge, of: "goto" });
  expect(innerEdge(states, nested, "start forward")).toBeNull();
});

test("the edge of a decision is found where it is drawn", () => {
  const edges = [
    { from: "start", to: "forward", when: ["always"] },
    { from: "forward", to: "done", when: ["always"] },
  ];
  expect(edgeOf(edges, { state: "forward", next: "done" })).toBe("forward done");
  expect(edgeOf(edges, { state: "start", next: "done" })).toBeNull(); // it is gone
  expect(edgeOf(edges, { state: "", next: "done" })).toBe("forward done"); // stateless: one of any
  expect(edgeOf(edges, undefined)).toBeNull();
});
