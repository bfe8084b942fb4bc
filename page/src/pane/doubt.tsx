/** Examples that a correction speaks against: which, why, and one click that lets them teach nothing. */

import { useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import type { Doubt } from "../protocol";
import { plain } from "../words";

export function DoubtCard() {
  const studio = useStudio();
  const panel = usePanel();
  const [passed, pass] = useState<Doubt | null>(null);
  const doubt = studio.session?.doubt ?? null;
  if (doubt === null || doubt.reason === passed?.reason) return null;
  const numbers = doubt.suspects.map(({ number }) => number);
  const one = numbers.length === 1;
  return (
    <section class="doubt" role="status" aria-label="Doubtful examples">
      <p>{plain(doubt.reason)}</p>
      <ul>
        {doubt.suspects.map(({ number, reason }) => (
          <li key={number}>{plain(reason)}</li>
        ))}
      </ul>
      <p class="choices">
        <ControlButton class="small primary" request={{ do: "quarantine", numbers }} back={{ do: "undo" }}>
          {one ? `Put example ${numbers[0]} in quarantine` : "Put them in quarantine"}
        </ControlButton>
        <Button class="small" onClick={() => panel.showExamples(numbers)}>
          Show {one ? "it" : "them"}
        </Button>
        <Button class="small" onClick={() => pass(doubt)}>
          {one ? "It is right" : "They are right"}
        </Button>
      </p>
    </section>
  );
}
