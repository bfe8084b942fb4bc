/** Where the states and the transitions between them are drawn. */

import { Graph, layout } from "@dagrejs/dagre";
import type { Arrow, NestedAutomaton, NestedState, Way } from "./protocol";

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
export type DrawnState = NestedState & { arrow?: Arrow | null };

export interface Node {
  state: DrawnState;
  /** Where it is, from the outermost state inwards. */
  path: string;
  /** What it runs, while it is open. */
  inner: Drawing | null;
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Bend {
  edge: Way;
  id: string;
  points: Point[];
}

export interface Drawing {
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
  edges: readonly Way[],
  decision: { state: string; next: string } | undefined,
): string | null {
  const found = edges.find(
    ({ from, to }) => to === decision?.next && (decision.state === "" || from === decision.state),
  );
  return found === undefined ? null : edgeId(found);
}

/** An edge wherever it is drawn: the path of the state whose automaton it belongs to, then the edge. */
function arcId(above: string, edge: Way): string {
  return above === "" ? edgeId(edge) : `${above}\n${edgeId(edge)}`;
}

/** The edge of a nested automaton by the id that it is drawn with, and the automaton it belongs to. */
export function innerEdge(
  states: readonly DrawnState[],
  nested: Readonly<Record<string, NestedAutomaton>>,
  id: string,
  above = "",
): { edge: Way; of: string } | null {
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

export function drawing(
  states: readonly DrawnState[],
  edges: readonly Way[],
  name: (state: DrawnState) => string,
  opened: ReadonlySet<string> = new Set(),
  nested: Readonly<Record<string, NestedAutomaton>> = {},
  above = "",
): Drawing {
  const inside = (state: DrawnState): Drawing | null => {
    const inner = state.automaton === null ? undefined : nested[state.automaton];
    const path = `${above}/${state.name}`;
    if (inner === undefined || !opened.has(path)) return null;
    return drawing(inner.states, inner.edges, name, opened, nested, path);
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
  const known = new Set(states.map((state) => state.name));
  const drawn = edges.filter(({ from, to }) => from !== to && known.has(from) && known.has(to));
  for (const edge of drawn) graph.setEdge(edge.from, edge.to, {}, edgeId(edge));
  const wide = (state: DrawnState): number => (graph.node(state.name) as { width: number }).width;
  for (const [from, to] of loose(states, drawn, wide)) graph.setEdge(from, to, {}, "loose");
  layout(graph);
  const size = graph.graph() as { width?: number; height?: number };
  return faced({
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
function faced(drawing: Drawing): Drawing {
  const place = (arrow: Arrow): number => drawing.nodes.find(({ state }) => state.arrow === arrow)?.x ?? NaN;
  if (!(place("left") > place("right"))) return drawing;
  const flipped = <T extends Point>(point: T): T => ({ ...point, x: drawing.width - point.x });
  return {
    ...drawing,
    nodes: drawing.nodes.map(flipped),
    arcs: drawing.arcs.map((arc) => ({ ...arc, points: arc.points.map(flipped) })),
  };
}

/** States that nothing leads to yet stand below the start state, in rows, and flags below them. */
function loose(
  states: readonly DrawnState[],
  edges: readonly Way[],
  wide: (state: DrawnState) => number,
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
function inRows(states: readonly DrawnState[], wide: (state: DrawnState) => number): DrawnState[][] {
  const rows: DrawnState[][] = [];
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
  let path = `M${at(first)}`;
  rest.forEach((point, index) => {
    const next = rest[index + 1];
    const end = next === undefined ? last : { x: (point.x + next.x) / 2, y: (point.y + next.y) / 2 };
    path += `Q${at(point)} ${at(end)}`;
  });
  return rest.length === 0 ? `${path}L${at(last)}` : path;
}

function at({ x, y }: Point): string {
  return `${x.toFixed(1)} ${y.toFixed(1)}`;
}
