/** The tab Automaton: the graph, the rules in words, and the explanation of the present decision. */

import { useState } from "preact/hooks";
import { Button } from "../button";
import { ChangeCard } from "../changes";
import { usePanel, useStudio } from "../context";
import { edgeId, innerEdge } from "../graph";
import type { Panel } from "../panel";
import type { Edge, Transition } from "../protocol";
import { className, plain } from "../words";
import { GraphView } from "./graph";
import { PruningLine, SimplifyCard } from "./simplify";
import { Why } from "./why";

export function AutomatonTab() {
  const studio = useStudio();
  const panel = usePanel();
  const [simplifying, simplify] = useState(false);
  const { session } = studio;
  if (session === null) {
    return (
      <p class="empty">
        Here you will see the automaton that you teach: its states, and when it goes from one to another.
      </p>
    );
  }
  const picked = session.edges.find((edge) => edgeId(edge) === panel.edge);
  const inner = panel.edge === null ? null : innerEdge(session.states, session.nested, panel.edge);
  const edges = picked === undefined ? session.edges : [picked];
  return (
    <>
      <GraphView session={session} panel={panel} last={studio.switch} />
      {session.path.length > 1 && (
        <p class="tiny path" data-path={session.path.join("/")}>
          now {session.path.map(plain).join(" › ")}
        </p>
      )}
      <ChangeCard />
      <Why />
      <div class="rules-head">
        <h3>
          {inner !== null
            ? `This transition, in ${plain(inner.of)}`
            : picked === undefined
              ? "What it learned"
              : "This transition"}
        </h3>
        {(picked !== undefined || inner !== null) && (
          <Button class="link" onClick={() => panel.selectEdge(null)}>
            show all
          </Button>
        )}
        {picked === undefined && inner === null && !simplifying && (
          <PruningLine session={session} show={() => simplify(true)} />
        )}
      </div>
      {simplifying && <SimplifyCard session={session} panel={panel} close={() => simplify(false)} />}
      {session.edges.length === 0 && (
        <p class="empty">
          Nothing yet. Press a state below the world to direct the robot: each press is an example, and from
          examples it learns when to switch.
        </p>
      )}
      <ul class="rules">
        {inner !== null ? (
          <li class="card rule picked">
            <b class="rule-name">
              {plain(inner.edge.from)} → {plain(inner.edge.to)}
            </b>
            <Conditions edge={inner.edge} />
          </li>
        ) : (
          edges.map((edge) => <Rule key={edgeId(edge)} edge={edge} panel={panel} picked={edge === picked} />)
        )}
      </ul>
    </>
  );
}

function Rule({ edge, panel, picked }: { edge: Edge; panel: Panel; picked: boolean }) {
  return (
    <li class={className("card", "rule", picked && "picked")}>
      <Button class="rule-name" aria-expanded={picked} onClick={() => panel.selectEdge(edgeId(edge))}>
        {plain(edge.from)} → {plain(edge.to)}
      </Button>
      <Conditions edge={edge} />
      {edge.examples.length > 0 && (
        <p class="tiny">
          shown by{" "}
          <Button class="link" onClick={() => panel.showExamples(edge.examples)}>
            {edge.examples.length === 1 ? "example" : "examples"} {edge.examples.slice(0, 8).join(", ")}
            {edge.examples.length > 8 ? " …" : ""}
          </Button>
        </p>
      )}
    </li>
  );
}

function Conditions({ edge }: { edge: Transition }) {
  return (
    <>
      {edge.when.map((when, index) => (
        <p class="condition" key={when}>
          <span class="soft">{index > 0 ? "or " : ""}</span>
          {when === "always" ? "always" : <When text={when.replace(/^when /, "")} />}
        </p>
      ))}
    </>
  );
}

/** Between two statements, not between the ends of one: "x is between 1 m and 2 m and y is yes". */
const JOINT = / and (?=\S+(?: [^ ]+\))? is )/;

/** A condition, its statements apart. */
function When({ text }: { text: string }) {
  return (
    <>
      <span class="soft">when </span>
      {text.split(JOINT).map((statement, index) => (
        <span key={statement}>
          {index > 0 && <span class="soft"> and </span>}
          <b>{plain(statement)}</b>
        </span>
      ))}
    </>
  );
}
