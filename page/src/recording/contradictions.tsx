/** Where drivers contradict each other, and who is right: for one contradiction, or for all. */

import { Button } from "../button";
import { Select } from "../fields";
import type { Contradiction, LearnedDrive, Review } from "../protocol";
import { className, formatCount, plain } from "../words";
import { ReviewButton } from "./bar";
import { around, type Recording } from "./recording";

interface ContradictionsProps {
  recording: Recording;
  review: Review;
  learned: LearnedDrive;
}

export function Contradictions({ recording, review, learned }: ContradictionsProps) {
  if (review.drivers.length < 2) return null;
  const { contradictions } = learned;
  const open = contradictions.filter(({ trust }) => trust === null).length;
  return (
    <section class="contradictions" aria-label="Contradictions">
      <h3>Contradictions</h3>
      {contradictions.length === 0 ? (
        <p class="soft">The drivers do not contradict each other.</p>
      ) : (
        <p class="soft">
          {open === 0 ? "All are settled." : `${formatCount(open, "contradiction")} to settle: who is right?`}
        </p>
      )}
      <ul>
        {contradictions.map((each, index) => (
          <Row
            key={each.choices.map(({ description }) => description).join()}
            recording={recording}
            review={review}
            contradiction={each}
            index={index}
          />
        ))}
      </ul>
      {(contradictions.length > 0 || review.trust !== null) && (
        <label class="flex trust">
          Right everywhere else
          <Select
            value={review.trust ?? ""}
            among={[["", "undecided"], ...review.drivers.map((driver) => [driver, driver] as const)]}
            disabled={recording.busy !== null}
            change={(driver) => void recording.ask({ do: "trust", driver: driver || null })}
          />
        </label>
      )}
      {open > 0 && (
        <p class="tiny soft">
          What others showed against the driver who is right is left out. Until you decide, all of it teaches.
        </p>
      )}
    </section>
  );
}

interface RowProps {
  recording: Recording;
  review: Review;
  contradiction: Contradiction;
  index: number;
}

function Row({ recording, review, contradiction, index }: RowProps) {
  const { choices, trust } = contradiction;
  return (
    <li class={className(trust !== null && "settled")}>
      {choices.map(({ driver, description, tick }) => (
        <p key={driver}>
          <Button class="link" onClick={() => recording.select(around(review, tick))}>
            {plain(description)}
          </Button>
        </p>
      ))}
      {trust === null ? (
        <div class="answers">
          {choices.map(({ driver }) => (
            <ReviewButton
              key={driver}
              recording={recording}
              request={{ do: "settle", contradiction: index, trust: driver }}
            >
              {driver} is right
            </ReviewButton>
          ))}
        </div>
      ) : (
        <p class="tiny soft">Settled: {trust} is right.</p>
      )}
    </li>
  );
}
