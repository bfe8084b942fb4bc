/** What changed between two versions: when it switches, because of whom, and all else. */

import { useEffect, useState } from "preact/hooks";
import { Button } from "../button";
import { ConditionChanges } from "../changes";
import { usePanel, useStudio } from "../context";
import { Select } from "../fields";
import type { Answer, Moved, Version } from "../protocol";
import { className, formatCount, useMinusSign, plain } from "../words";

const MOST_EXAMPLES = 6;

interface ChangesProps {
  name: string;
  version: number;
  /** How many former versions there are. */
  count: number;
  versions: readonly Version[];
}

export function Changes({ name, version, count, versions }: ChangesProps) {
  const studio = useStudio();
  const [to, setTo] = useState<number | null>(null);
  const [answer, setAnswer] = useState<Answer | null>(null);
  useEffect(() => {
    void studio.ask({ do: "diff_versions", name, version, to }).then(setAnswer);
  }, [name, version, to, count]);
  if (answer?.changes === undefined || answer.moved === undefined) return null;
  const { changes, moved } = answer;
  const lines = changes.flatMap((each) => each.lines).filter((line) => /^[+-]/.test(line)).length;
  const others = versions.filter(({ number }) => number !== version);
  return (
    <div class="changes" role="region" aria-label={`What changed since version ${version}`}>
      <p class="tiny">
        {lines + moved.length === 0 ? "Nothing changed" : formatCount(lines + moved.length, "change")} up to{" "}
        <Select
          aria-label={`What version ${version} is compared with`}
          value={String(to ?? "")}
          among={[
            ["", "the present version"],
            ...others.map(({ number }) => [String(number), `version ${number}`] as const),
          ]}
          change={(number) => setTo(number === "" ? null : Number(number))}
        />
      </p>
      {moved.length > 0 && <h4>When it switches</h4>}
      {moved.map((each) => (
        <Switch key={`${each.from} ${each.to}`} moved={each} here={studio.session?.name === name} />
      ))}
      {changes.map(({ topic, lines: text }) => (
        <div key={topic}>
          <h4>{topic}</h4>
          {text.map((line, index) => (
            <p key={index} class={className("change", /^\+/.test(line) && "new", /^-/.test(line) && "gone")}>
              {plain(line.startsWith("-") ? useMinusSign(line) : line.trim())}
            </p>
          ))}
        </div>
      ))}
    </div>
  );
}

/** One switch that moved, appeared or vanished; its examples open in the lesson where that is the one in training. */
function Switch({ moved, here }: { moved: Moved; here: boolean }) {
  const studio = useStudio();
  const panel = usePanel();
  const numbers = new Set(here ? studio.session?.examples.map(({ number }) => number) : []);
  const { examples } = moved;
  return (
    <div class="moved">
      <p>
        <b>
          {plain(moved.from)} → {plain(moved.to)}
        </b>{" "}
        {plain(moved.what)}
      </p>
      <ConditionChanges was={moved.gone} now={moved.new} />
      <p class="tiny">
        {examples.length === 0
          ? "it is learned otherwise"
          : `because of example${examples.length > 1 ? "s" : ""} `}
        {examples.slice(0, MOST_EXAMPLES).map(({ number, happened, how }, index) => (
          <span key={number}>
            {index > 0 && ", "}
            {numbers.has(number) ? (
              <Button class="link" onClick={() => panel.openExample(number)}>
                {number}
              </Button>
            ) : (
              number
            )}{" "}
            ({happened}, {how})
          </span>
        ))}
        {examples.length > MOST_EXAMPLES && ` and ${examples.length - MOST_EXAMPLES} more`}
      </p>
    </div>
  );
}
