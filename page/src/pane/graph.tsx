/** The automaton as a graph: the active state lit, the last transition flashing, every edge to be clicked. */

import { useMemo } from "preact/hooks";
import { curve, drawing, edgeId, type Bend, type Node } from "../graph";
import type { Panel } from "../panel";
import type { Desk } from "../protocol";
import type { Switch } from "../studio";
import { className, counted } from "../words";

const LARGEST = 1.15;
const MOST_HIGH = 300;
const WIDE = 340;

interface GraphProps {
  desk: Desk;
  panel: Panel;
  last: Switch | null;
}

export function GraphView({ desk, panel, last }: GraphProps) {
  const shape = desk.states.map(({ name, flag }) => `${name} ${flag}`).join();
  const edges = desk.edges.map(edgeId).join();
  const drawn = useMemo(
    () => drawing(desk.states, desk.edges, ({ name, flag }) => name + (flag ? " ⚑" : "")),
    [shape, edges],
  );
  const scale = Math.min(LARGEST, WIDE / drawn.width, MOST_HIGH / drawn.height);
  const number = new Map(desk.edges.map((edge) => [edgeId(edge), edge.examples.length]));
  return (
    <svg
      class={className("graph", desk.mode)}
      viewBox={`0 0 ${drawn.width} ${drawn.height}`}
      width={drawn.width * scale}
      height={drawn.height * scale}
      role="group"
      aria-label={`The automaton ${desk.name}`}
    >
      <defs>
        {["line", "picked", "flash"].map((name) => (
          <marker
            key={name}
            id={`head-${name}`}
            class={`head ${name}`}
            viewBox="0 0 8 8"
            refX="7"
            refY="4"
            markerUnits="userSpaceOnUse"
            markerWidth="9"
            markerHeight="9"
            orient="auto"
          >
            <path d="M0 0.6 7.6 4 0 7.4Z" />
          </marker>
        ))}
      </defs>
      {drawn.arcs.map((arc) => (
        <ArcView key={arc.id} arc={arc} panel={panel} last={last} examples={number.get(arc.id) ?? 0} />
      ))}
      {drawn.nodes.map((node, index) => (
        <NodeView key={node.state.name} node={node} desk={desk} first={index === 0} />
      ))}
    </svg>
  );
}

interface ArcProps {
  arc: Bend;
  panel: Panel;
  last: Switch | null;
  examples: number;
}

function ArcView({ arc, panel, last, examples }: ArcProps) {
  const picked = panel.edge === arc.id;
  const flash = last !== null && edgeId(last) === arc.id;
  const path = curve(arc.points);
  const head = picked ? "picked" : "line";
  return (
    <g
      class={className("arc", picked && "picked", flash && last.corrected && "corrected")}
      role="button"
      tabindex={0}
      aria-pressed={picked}
      aria-label={`${arc.edge.from} to ${arc.edge.to}, ${counted(examples, "example")}`}
      onClick={() => panel.selectEdge(arc.id)}
      onKeyDown={(event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        panel.selectEdge(arc.id);
      }}
    >
      <path class="reach" d={path} />
      <path
        class="line"
        d={path}
        marker-end={`url(#head-${head})`}
        style={{ strokeWidth: Math.min(1 + 0.5 * Math.log2(1 + examples), 3) }}
      />
      {flash && <path key={`${last.at}`} class="flash" d={path} marker-end="url(#head-flash)" />}
    </g>
  );
}

function NodeView({ node, desk, first }: { node: Node; desk: Desk; first: boolean }) {
  const { state, x, y, width, height } = node;
  const active = desk.state === state.name;
  const waiting = desk.waiting === state.name;
  return (
    <g
      class={className("node", active && "on", waiting && "waiting", state.flag && "flag", first && "start")}
    >
      <rect x={x - width / 2} y={y - height / 2} width={width} height={height} rx={first ? height / 2 : 8} />
      <text x={x} y={y + 4} text-anchor="middle">
        {state.name}
        {state.flag ? " ⚑" : ""}
      </text>
    </g>
  );
}
