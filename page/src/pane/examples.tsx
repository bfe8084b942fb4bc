/** The table of examples, the latest first; a selected one can be changed and deleted. */

import { useEffect, useRef } from "preact/hooks";
import { Button } from "../button";
import { Sign, useFirst } from "../lists";
import type { Panel } from "../panel";
import type { Example, Session } from "../protocol";
import { className, formatTime, plain } from "../words";
import { Detail } from "./example";

type Kind = Example["kind"] | "correction";

/** How an example came about: a sign of it, and the word for it. */
export const KINDS: Readonly<Record<Kind, readonly [sign: string, word: string]>> = {
  directive: ["●", "press"],
  correction: ["▲", "correction"],
  confirmation: ["↵", "keep"],
  default: ["○", "default"],
  watched: ["◌", "watched"],
};

export function kindOf({ kind, correction }: Pick<Example, "kind" | "correction">): Kind {
  return correction ? "correction" : kind;
}

export function KindSign({ example }: { example: Pick<Example, "kind" | "correction"> }) {
  const [sign, word] = KINDS[kindOf(example)];
  return <Sign means={word}>{sign}</Sign>;
}

/** The number of examples that are listed at first: a watched lesson has thousands. */
const LATEST = 400;

export interface TableProps {
  session: Session;
  panel: Panel;
}

export function Examples({ session, panel }: TableProps) {
  const latestFirst = [...session.examples].reverse();
  const [rows, more] = useFirst(
    latestFirst,
    panel.highlighted.size > 0 ? Infinity : LATEST,
    (hidden) => `show the ${hidden} before`,
  );
  const body = useRef<HTMLTableSectionElement>(null);
  useEffect(() => {
    body.current?.querySelector(".shown")?.scrollIntoView({ block: "center" });
  }, [panel.highlighted]);
  return (
    <>
      <table class="examples">
        <thead>
          <tr>
            <th class="number">#</th>
            <th>state</th>
            <th>next</th>
            {session.features.map(({ label, unit }) => (
              <th key={label} class="number" title={unit === "" ? plain(label) : `${plain(label)}, ${unit}`}>
                {shorten(label)}
              </th>
            ))}
            <th aria-label="how" />
            <th class="number">time</th>
          </tr>
        </thead>
        <tbody ref={body}>
          {rows.map((example) => (
            <Row key={example.number} example={example} session={session} panel={panel} />
          ))}
        </tbody>
      </table>
      {more}
    </>
  );
}

function Row({ example, session, panel }: TableProps & { example: Example }) {
  const { number, correction, contradicts } = example;
  const picked = panel.example === number;
  const marks = [picked && "picked", panel.highlighted.has(number) && "shown", correction && "correction"];
  return (
    <>
      <tr
        class={className(
          ...marks,
          contradicts && "contradicts",
          example.kind,
          example.quarantined !== "" && "held",
        )}
        aria-selected={picked}
        onClick={() => panel.selectExample(number)}
      >
        <td class="number">
          <Button class="link" aria-expanded={picked} aria-label={`Example ${number}`}>
            {number}
          </Button>
        </td>
        <td>{plain(example.state)}</td>
        <td>{example.next === example.state ? <span class="soft">stay</span> : plain(example.next)}</td>
        {example.values.map((value, index) => (
          <td key={session.features[index]?.label} class="number">
            {bare(value, session.features[index]?.unit ?? "")}
          </td>
        ))}
        <td class="kind">
          {contradicts && (
            <span class="warn" title="Contradicts another example: same readings, different press">
              ≠{" "}
            </span>
          )}
          {example.quarantined !== "" && (
            <Sign tone="warn" means="in quarantine" title={`In quarantine. ${example.quarantined}`}>
              ⊘{" "}
            </Sign>
          )}
          <KindSign example={example} />
        </td>
        <td class="number soft">
          <span title={formatTime(example.time_s)}>{formatTime(example.time_s).replace(/\..*/, "")}</span>
        </td>
      </tr>
      {picked && (
        <tr class="picked detail">
          <td colSpan={5 + session.features.length}>
            <Detail example={example} session={session} panel={panel} />
          </td>
        </tr>
      )}
    </>
  );
}

/** A value in a column of meters needs no unit. */
function bare(value: string, unit: string): string {
  return unit !== "" && value.endsWith(` ${unit}`) ? value.slice(0, -unit.length - 1) : value;
}

/** distance_to(A) is "distance A" over a narrow column. */
function shorten(label: string): string {
  return plain(label.replace(/_to\b/, "").replace(/\((.+)\)/, " $1"));
}
