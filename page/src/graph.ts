/** Where the states and the transitions between them are drawn. */

import { Graph, layout } from "@dagrejs/dagre";
import type { Arrow, NestedAutomaton, NestedState, Transition } from "./protocol";

const LETTER = 7.2;
const PADDING = 26;
export const HEIGHT = 30;
/** Room for the button that opens a state. */
export const BUTTON = 20;
/** Between states side by side, and how much room they have together. */
const GAP = 26;
const ROW = 370;
/** Room around what an open state shows. */
const FRAME = 6;

interface Point {
  x: number;
  y: number;
}

/** A state of the automaton under training, which may have an arrow key, or of one below it. */
export type StateNode = NestedState & { arrow?: Arrow | null };

export interface Node {
  state: StateNode;
  /** Where it is, from the outermost state inwards. */
  path: string;
  /** What it runs, while it is open. */
  inner: GraphLayout | null;
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Bend {
  edge: Transition;
  id: string;
  points: Point[];
}

export interface GraphLayout {
  width: number;
  height: number;
  nodes: Node[];
  arcs: Bend[];
}

export function edgeId(edge: { from: string; to: string }): string {
  return `${edge.from} ${edge.to}`;
}

/** The id of the edge of a decision; null where none is drawn. Without a state, one of any. */
export function edgeOf(
  edges: readonly Transition[],
  decision: { state: string; next: string } | undefined,
): string | null {
  const edge = edges.find(
    ({ from, to }) => to === decision?.next && (decision.state === "" || from === decision.state),
  );
  return edge === undefined ? null : edgeId(edge);
}

/** The key of an edge on the page: the path of the state whose automaton it belongs to, then the edge. */
function arcId(above: string, edge: Transition): string {
  return above === "" ? edgeId(edge) : `${above}\n${edgeId(edge)}`;
}

/** The edge of a nested automaton by the id that it is drawn with, and the automaton it belongs to. */
export function innerEdge(
  states: readonly StateNode[],
  nested: Readonly<Record<string, NestedAutomaton>>,
  id: string,
  above = "",
): { edge: Transition; of: string } | null {
  for (const { name, automaton } of states) {
    const path = `${above}/${name}`;
    const inner = automaton === null ? undefined : nested[automaton];
    if (automaton === null || inner === undefined) continue;
    const edge = inner.edges.find((each) => arcId(path, each) === id);
    if (edge !== undefined) return { edge, of: automaton };
    const deeper = id.startsWith(`${path}/`) ? innerEdge(inner.states, nested, id, path) : null;
    if (deeper !== null) return deeper;
  }
  return null;
}

export function layoutGraph(
  states: readonly StateNode[],
  edges: readonly Transition[],
  name: (state: StateNode) => string,
  opened: ReadonlySet<string> = new Set(),
  nested: Readonly<Record<string, NestedAutomaton>> = {},
  above = "",
): GraphLayout {
  const inside = (state: StateNode): GraphLayout | null => {
    const inner = state.automaton === null ? undefined : nested[state.automaton];
    const path = `${above}/${state.name}`;
    if (inner === undefined || !opened.has(path)) return null;
    return layoutGraph(inner.states, inner.edges, name, opened, nested, path);
  };
  const inner = new Map(states.map((state) => [state.name, inside(state)]));
  const graph = new Graph({ multigraph: true });
  graph.setGraph({ rankdir: "TB", nodesep: GAP, edgesep: 18, ranksep: 40, marginx: 10, marginy: 10 });
  graph.setDefaultEdgeLabel(() => ({}));
  for (const state of states) {
    const title = name(state).length * LETTER + PADDING + (state.automaton === null ? 0 : 2 * BUTTON);
    const { width = 0, height = -FRAME } = inner.get(state.name) ?? {};
    graph.setNode(state.name, { width: Math.max(title, width + 2 * FRAME), height: HEIGHT + height + FRAME });
  }
  const names = new Set(states.map((state) => state.name));
  const drawn = edges.filter(({ from, to }) => from !== to && names.has(from) && names.has(to));
  for (const edge of drawn) graph.setEdge(edge.from, edge.to, {}, edgeId(edge));
  const wide = (state: StateNode): number => (graph.node(state.name) as { width: number }).width;
  for (const [from, to] of connectLoose(states, drawn, wide)) graph.setEdge(from, to, {}, "loose");
  layout(graph);
  const size = graph.graph() as { width?: number; height?: number };
  return mirrorTurns({
    width: size.width ?? 1,
    height: size.height ?? 1,
    nodes: states.map((state) => {
      const at = graph.node(state.name) as { x?: number; y?: number; width: number; height: number };
      const path = `${above}/${state.name}`;
      const { width, height } = at;
      return { state, path, inner: inner.get(state.name) ?? null, x: at.x ?? 0, y: at.y ?? 0, width, height };
    }),
    arcs: drawn.map((edge) => {
      const label = graph.edge(edge.from, edge.to, edgeId(edge)) as { points?: Point[] };
      return { edge, id: arcId(above, edge), points: label.points ?? [] };
    }),
  });
}

/** Turning left is drawn left of turning right. */
function mirrorTurns(drawing: GraphLayout): GraphLayout {
  const place = (arrow: Arrow): number => drawing.nodes.find(({ state }) => state.arrow === arrow)?.x ?? NaN;
  if (!(place("left") > place("right"))) return drawing;
  const mirror = <T extends Point>(point: T): T => ({ ...point, x: drawing.width - point.x });
  return {
    ...drawing,
    nodes: drawing.nodes.map(mirror),
    arcs: drawing.arcs.map((arc) => ({ ...arc, points: arc.points.map(mirror) })),
  };
}

/** States that nothing leads to yet stand below the start state, in rows, and flags below them. */
function connectLoose(
  states: readonly StateNode[],
  edges: readonly Transition[],
  wide: (state: StateNode) => number,
): [string, string][] {
  const [start, ...others] = states;
  if (start === undefined) return [];
  const middle = others.filter((state) => !state.flag);
  const reached = new Set(edges.map((edge) => edge.to));
  const rows = inRows(
    middle.filter((state) => !reached.has(state.name)),
    wide,
  );
  const last = rows.at(-1) ?? middle;
  const over = last[Math.floor((last.length - 1) / 2)] ?? start;
  return [
    ...rows.flatMap((row, index) =>
      row.map((state, at): [string, string] => [rows[index - 1]?.[at]?.name ?? start.name, state.name]),
    ),
    ...others
      .filter((state) => state.flag && !reached.has(state.name))
      .map((state): [string, string] => [over.name, state.name]),
  ];
}

/** As many in a row as can be read side by side. */
function inRows(states: readonly StateNode[], wide: (state: StateNode) => number): StateNode[][] {
  const rows: StateNode[][] = [];
  let room = 0;
  for (const state of states) {
    room -= wide(state) + GAP;
    if (room < 0 || rows.length === 0) {
      rows.push([]);
      room = ROW - wide(state);
    }
    rows.at(-1)?.push(state);
  }
  return rows;
}

/** A smooth line: through the first and last point, and bending at those between. */
export function curve(points: readonly Point[]): string {
  const [first, ...rest] = points;
  const last = rest.pop();
  if (first === undefined || last === undefined) return "";
  let path = `M${formatPoint(first)}`;
  rest.forEach((point, index) => {
    const next = rest[index + 1];
    const end = next === undefined ? last : { x: (point.x + next.x) / 2, y: (point.y + next.y) / 2 };
    path += `Q${formatPoint(point)} ${formatPoint(end)}`;
  });
  return rest.length === 0 ? `${path}L${formatPoint(last)}` : path;
}

function formatPoint({ x, y }: Point): string {
  return `${x.toFixed(1)} ${y.toFixed(1)}`;
}
