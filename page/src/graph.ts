/** Where the states and the transitions between them are drawn. */

import { Graph, layout } from "@dagrejs/dagre";
import type { Arrow, Edge, State } from "./protocol";

const LETTER = 6.7;
const PADDING = 26;
const HEIGHT = 30;

interface Point {
  x: number;
  y: number;
}

export interface Node {
  state: State;
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Bend {
  edge: Edge;
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

export function drawing(
  states: readonly State[],
  edges: readonly Edge[],
  name: (state: State) => string,
): Drawing {
  const graph = new Graph({ multigraph: true });
  graph.setGraph({ rankdir: "TB", nodesep: 26, edgesep: 18, ranksep: 40, marginx: 10, marginy: 10 });
  graph.setDefaultEdgeLabel(() => ({}));
  for (const state of states) {
    const width = name(state).length * LETTER + PADDING;
    graph.setNode(state.name, { width, height: HEIGHT });
  }
  const known = new Set(states.map((state) => state.name));
  const drawn = edges.filter(({ from, to }) => from !== to && known.has(from) && known.has(to));
  for (const edge of drawn) graph.setEdge(edge.from, edge.to, {}, edgeId(edge));
  for (const [from, to] of loose(states, drawn)) graph.setEdge(from, to, {}, "loose");
  layout(graph);
  const size = graph.graph() as { width?: number; height?: number };
  return faced({
    width: size.width ?? 1,
    height: size.height ?? 1,
    nodes: states.map((state) => {
      const at = graph.node(state.name) as { x?: number; y?: number; width: number; height: number };
      return { state, x: at.x ?? 0, y: at.y ?? 0, width: at.width, height: at.height };
    }),
    arcs: drawn.map((edge) => {
      const label = graph.edge(edge.from, edge.to, edgeId(edge)) as { points?: Point[] };
      return { edge, id: edgeId(edge), points: label.points ?? [] };
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

/** States that nothing leads to yet stand below the start state, flags below them. */
function loose(states: readonly State[], edges: readonly Edge[]): [string, string][] {
  const [start, ...others] = states;
  if (start === undefined) return [];
  const middle = others.filter((state) => !state.flag);
  const reached = new Set(edges.map((edge) => edge.to));
  const over = middle[Math.floor((middle.length - 1) / 2)] ?? start;
  return others
    .filter((state) => !reached.has(state.name))
    .map((state) => [state.flag ? over.name : start.name, state.name]);
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
