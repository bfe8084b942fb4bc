/** Changed decisions after a press or an edit, beyond its own: a line beside the world, and every change in full. */

import { useState } from "preact/hooks";
import { Button, CloseButton } from "./button";
import { usePanel, useStudio } from "./context";
import { edgeOf } from "./graph";
import type { ChangeSummary } from "./protocol";
import { plain } from "./words";

/** The line; it is gone after an undo, and stays closed until the lesson changes again. */
export function ChangeLine() {
  const studio = useStudio();
  const panel = usePanel();
  const [closed, close] = useState<string | null>(null);
  const { session } = studio;
  if (session === null || session.changed === null) return null;
  const { line, changes } = session.changed;
  const now = `${session.name} ${session.edition}`;
  if (closed === now) return null;
  return (
    <div class="toast changed" key={now}>
      <span>
        <b>Changed:</b> {plain(line)}
      </span>
      {studio.hasControl && <Button onClick={() => void studio.ask({ do: "undo" })}>undo</Button>}
      <Button onClick={() => panel.showChanges(edgeOf(session.edges, changes[0]))}>show me</Button>
      <CloseButton label="Close" onClick={() => close(now)} />
    </div>
  );
}

/** In the tab Automaton, where it was asked for: what each changed decision looked like, and looks like now. */
export function ChangeCard() {
  const { session } = useStudio();
  const panel = usePanel();
  if (!panel.showsChanges || session === null || session.changed === null) return null;
  return (
    <section class="reasons changes" aria-label="What changed">
      <CloseButton class="link close" label="Close what changed" onClick={() => panel.hideChanges()} />
      <DecisionChanges summary={session.changed} />
    </section>
  );
}

/** All changes, each with its former and its present conditions. */
export function DecisionChanges({ summary }: { summary: ChangeSummary }) {
  return (
    <>
      {summary.changes.map(({ state, next, said, was, now }) => (
        <div class="moved" key={`${state} ${next}`}>
          <p>{plain(said)}</p>
          <ConditionChanges was={was} now={now} />
        </div>
      ))}
    </>
  );
}

/** The conditions that are gone, and those that are new. */
export function ConditionChanges({ was, now }: { was: readonly string[]; now: readonly string[] }) {
  const list = (sign: string, name: string, these: readonly string[], others: readonly string[]) =>
    these
      .filter((when) => !others.includes(when))
      .map((when) => (
        <p key={sign + when} class={`change ${name}`}>
          {sign} {plain(when)}
        </p>
      ));
  return (
    <>
      {list("−", "gone", was, now)}
      {list("+", "new", now, was)}
    </>
  );
}
