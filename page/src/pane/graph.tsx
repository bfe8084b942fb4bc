/** The automaton as a graph: the active state lit, the last transition flashing, every edge to be clicked. */

import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { BUTTON, curve, layoutGraph, edgeId, HEIGHT, type Bend, type Node } from "../graph";
import type { Panel } from "../panel";
import type { Session } from "../protocol";
import type { Switch } from "../studio";
import { className, formatCount, isSmall, plain } from "../words";

const LARGEST = 1.15;
/** On a small screen letters are 13 px high at this scale. */
const READABLE = 1;
/** Smaller could not be read: then it is scrolled. */
const LEAST = 0.8;
const MOST_HIGH = 300;
/** While something is open in it. */
const LEAST_OPEN = 0.6;
const MOST_HIGH_OPEN = 520;
const WIDE = 356;

interface GraphProps {
  session: Session;
  panel: Panel;
  last: Switch | null;
}

export function GraphView({ session, panel, last }: GraphProps) {
  const [opened, setOpened] = useState<ReadonlySet<string>>(new Set());
  const open = (path: string): void => setOpened((before) => togglePath(before, path));
  const shape = session.states.map(({ name, flag }) => `${name} ${flag}`).join();
  const edges = session.edges.map(edgeId).join();
  const drawn = useMemo(
    () =>
      layoutGraph(
        session.states,
        session.edges,
        ({ name, flag }) => plain(name) + (flag ? " ⚑" : ""),
        opened,
        session.nested,
      ),
    [shape, edges, opened, Object.keys(session.nested).join()],
  );
  const within = drawn.nodes.some(({ inner }) => inner !== null);
  const [drawnLeast, most] = within ? [LEAST_OPEN, MOST_HIGH_OPEN] : [LEAST, MOST_HIGH];
  const least = isSmall() ? READABLE : drawnLeast;
  const scale = Math.max(least, Math.min(LARGEST, WIDE / drawn.width, most / drawn.height));
  const wide = drawn.width * scale > WIDE;
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const on = drawn.nodes.find(({ state }) => state.name === session.state);
    if (!wide || on === undefined || place.current === null) return;
    place.current.scrollLeft = on.x * scale - place.current.clientWidth / 2;
  }, [session.state, drawn]);
  const number = new Map(session.edges.map((edge) => [edgeId(edge), edge.examples.length]));
  return (
    <div ref={place} class="graph-place" tabIndex={wide ? 0 : undefined}>
      <svg
        class={className("graph", session.mode)}
        viewBox={`0 0 ${drawn.width} ${drawn.height}`}
        width={drawn.width * scale}
        height={drawn.height * scale}
        role="group"
        aria-label={`The automaton ${plain(session.name)}`}
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
          <NodeView
            key={node.path}
            node={node}
            session={session}
            panel={panel}
            first={index === 0}
            level={0}
            lit
            open={open}
          />
        ))}
      </svg>
    </div>
  );
}

function togglePath(opened: ReadonlySet<string>, path: string): ReadonlySet<string> {
  const now = new Set(opened);
  if (!now.delete(path)) now.add(path);
  return now;
}

/** What makes a drawing a button, for the mouse and for the keys. */
function pressable(act: () => void) {
  const onKeyDown = (event: KeyboardEvent): void => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    act();
  };
  return { role: "button", tabindex: 0, onClick: act, onKeyDown } as const;
}

interface ArcProps {
  arc: Bend;
  panel: Panel;
  last: Switch | null;
  /** How many there are; those of nested automata are not at hand. */
  examples?: number;
  /** The nested automaton that it belongs to. */
  of?: string | null;
}

function ArcView({ arc, panel, last, examples, of }: ArcProps) {
  const picked = panel.edge === arc.id;
  const flash = last !== null && edgeId(last) === arc.id;
  const path = curve(arc.points);
  const head = picked ? "picked" : "line";
  return (
    <g
      class={className("arc", picked && "picked", flash && last.corrected && "corrected")}
      {...pressable(() => panel.selectEdge(arc.id))}
      aria-pressed={picked}
      aria-label={`${plain(arc.edge.from)} to ${plain(arc.edge.to)}, ${examples === undefined ? `in ${plain(of ?? "")}` : formatCount(examples, "example")}`}
    >
      <path class="reach" d={path} />
      <path
        class="line"
        d={path}
        marker-end={`url(#head-${head})`}
        style={{ strokeWidth: Math.min(1 + 0.5 * Math.log2(1 + (examples ?? 0)), 3) }}
      />
      {flash && <path key={`${last.at}`} class="flash" d={path} marker-end="url(#head-flash)" />}
    </g>
  );
}

interface NodeProps {
  node: Node;
  session: Session;
  panel: Panel;
  first: boolean;
  /** How deep it lies, and whether all around it are active. */
  level: number;
  lit: boolean;
  open: (path: string) => void;
}

function NodeView({ node, session, panel, first, level, lit, open }: NodeProps) {
  const { state, x, y, width, height, inner } = node;
  const active = lit && (level === 0 ? session.state : session.path[level]) === state.name;
  const waiting = level === 0 && session.pending === state.name;
  const top = y - height / 2;
  return (
    <g
      class={className("node", active && "on", waiting && "waiting", state.flag && "flag", first && "start")}
    >
      <rect x={x - width / 2} y={top} width={width} height={height} rx={first ? height / 2 : 8} />
      <text x={x} y={top + HEIGHT / 2 + 4} text-anchor="middle">
        {plain(state.name)}
        {state.flag ? " ⚑" : ""}
      </text>
      {state.automaton !== null && (
        <Opener node={node} at={{ x: x + width / 2 - BUTTON / 2 - 4, y: top + HEIGHT / 2 }} open={open} />
      )}
      {inner !== null && (
        <g class="inner" transform={`translate(${x - inner.width / 2} ${top + HEIGHT})`}>
          {inner.arcs.map((arc) => (
            <ArcView key={arc.id} arc={arc} panel={panel} last={null} of={state.automaton} />
          ))}
          {inner.nodes.map((each, index) => (
            <NodeView
              key={each.path}
              node={each}
              session={session}
              panel={panel}
              first={index === 0}
              level={level + 1}
              lit={active}
              open={open}
            />
          ))}
        </g>
      )}
    </g>
  );
}

interface OpenerProps {
  node: Node;
  at: { x: number; y: number };
  open: (path: string) => void;
}

/** Opens in place what a state runs, and closes it again. */
function Opener({ node: { state, path, inner }, at, open }: OpenerProps) {
  return (
    <g
      class="opener"
      {...pressable(() => open(path))}
      aria-expanded={inner !== null}
      aria-label={`What ${plain(state.name)} runs`}
    >
      <circle class="reach" cx={at.x} cy={at.y} r={22} />
      <circle cx={at.x} cy={at.y} r={8} />
      <path d={`M${at.x - 4} ${at.y}h8${inner === null ? `M${at.x} ${at.y - 4}v8` : ""}`} />
    </g>
  );
}
