/** The automaton with fewer questions beside the one there is: keep it so, or leave it. */

import { useEffect, useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { ConditionChanges } from "../changes";
import { useStudio } from "../context";
import type { Panel } from "../panel";
import type { Session, SimplifyPreview } from "../protocol";
import { formatCount, plain } from "../words";

const MOST_DECISIONS = 8;

interface PruningLineProps {
  session: Session;
  show: () => void;
}

/** How much is pruned, and a way to see what less or more would come to. */
export function PruningLine({ session, show }: PruningLineProps) {
  if (session.pruning === null || session.edges.length === 0) return null;
  return (
    <span class="pruned">
      <Button
        class="link"
        title="Shows the automaton with fewer questions, and what it would decide otherwise"
        onClick={show}
      >
        {session.pruning > 0 ? "simplified …" : "simplify …"}
      </Button>
      {session.pruning > 0 && (
        <ControlButton
          class="link"
          aria-label="Take simplifying back"
          title="All questions again"
          request={{ do: "prune", pruning: 0 }}
          back={{ do: "undo" }}
        >
          ×
        </ControlButton>
      )}
    </span>
  );
}

interface CardProps {
  session: Session;
  panel: Panel;
  close: () => void;
}

export function SimplifyCard({ session, panel, close }: CardProps) {
  const studio = useStudio();
  const [wanted, want] = useState<number | null>(null);
  const [preview, setPreview] = useState<SimplifyPreview | null>(null);
  useEffect(() => {
    let current = true;
    void studio.ask({ do: "simplify", pruning: wanted }).then(({ preview }) => {
      if (!current) return;
      if (preview === undefined) close();
      else setPreview(preview);
    });
    return () => {
      current = false;
    };
  }, [wanted, session.edition, session.name]);
  if (preview === null) return null;
  const changes = preview.states.length > 0;
  const keep = async (): Promise<void> => {
    const answer = await studio.change({ do: "prune", pruning: preview.pruning }, { do: "undo" });
    if (answer.error === undefined) close();
  };
  return (
    <section class="card simpler" aria-label="Simplify">
      <p>
        <b>
          {changes
            ? `${preview.leaves.before} answers become ${preview.leaves.after}.`
            : "Nothing would change."}
        </b>{" "}
        <Advice preview={preview} suggest={() => want(null)} />
      </p>
      <label class="tiny">
        A question stays if each of its answers sets more than{" "}
        <input
          type="number"
          min="0"
          step="0.5"
          value={preview.pruning}
          aria-label="examples"
          onChange={(event) => {
            const number = Number(event.currentTarget.value);
            if (event.currentTarget.value !== "" && number >= 0) want(number);
          }}
        />{" "}
        examples right.
      </label>
      {preview.states.map(({ state, before, after }) => (
        <Conditions key={state} state={state} before={before} after={after} />
      ))}
      {changes && <Decisions preview={preview} panel={panel} />}
      <p class="choices">
        {changes && (
          <ControlButton class="small primary" onClick={() => void keep()}>
            Keep
          </ControlButton>
        )}
        <Button class="small" onClick={close}>
          Leave
        </Button>
      </p>
    </section>
  );
}

/** What examples that were left out of learning say of it. */
function Advice({ preview, suggest }: { preview: SimplifyPreview; suggest: () => void }) {
  const { suggested, examples_needed, pruning } = preview;
  if (suggested === null) {
    return <>It has fewer than {examples_needed} examples, too few to prune.</>;
  }
  const { left_out: all, wrong, wrong_pruned: pruned } = suggested;
  if (suggested.pruning !== pruning) {
    return (
      <Button class="link" onClick={suggest}>
        as suggested
      </Button>
    );
  }
  return (
    <>
      Each of {formatCount(all, "example")} left out in turn: {pruned} decided wrongly so, {wrong} with all
      questions.
    </>
  );
}

function Conditions({ state, before, after }: SimplifyPreview["states"][number]) {
  return (
    <div class="changes">
      <h4>{plain(state)}</h4>
      {before
        .filter((line) => after.includes(line))
        .map((line) => (
          <p key={line} class="change">
            {plain(line)}
          </p>
        ))}
      <ConditionChanges was={before} now={after} />
    </div>
  );
}

/** The recorded moments at which it would decide otherwise. */
function Decisions({ preview, panel }: { preview: SimplifyPreview; panel: Panel }) {
  const { decisions, examples, moments } = preview;
  return (
    <div class="decisions">
      <p>
        {decisions.length} of {formatCount(examples, "example")} would be decided otherwise
        {moments.all > 0 && `, and ${moments.changed} of ${moments.all} moments before presses`}.
      </p>
      {decisions.slice(0, MOST_DECISIONS).map(({ number, state, shown: example, before, after }) => (
        <p key={number} class="tiny">
          <Button class="link" onClick={() => panel.openExample(number)}>
            {number}
          </Button>{" "}
          in {plain(state)}: {plain(before ?? "")} → {plain(after ?? "")} (
          {after === example ? "as shown" : `shown: ${plain(example)}`})
        </p>
      ))}
      {decisions.length > MOST_DECISIONS && (
        <p class="tiny">
          and{" "}
          <Button class="link" onClick={() => panel.showExamples(decisions.map(({ number }) => number))}>
            {decisions.length - MOST_DECISIONS} more
          </Button>
        </p>
      )}
    </div>
  );
}
