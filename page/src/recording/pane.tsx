/** Beside the timeline: what is selected, what is in doubt, and what was learned. */

import { useState } from "preact/hooks";
import { Button } from "../button";
import { Form, Input } from "../fields";
import type { BehaviorProposal, LearnedDrive, Review } from "../protocol";
import { className, formatCount, plain } from "../words";
import { Contradictions } from "./contradictions";
import type { Recording } from "./recording";
import { ReviewButton } from "./bar";
import { nameLabel, Swatch } from "./label";

interface PaneProps {
  recording: Recording;
  review: Review;
}

export function ReviewPane({ recording, review }: PaneProps) {
  return (
    <aside class="review-pane">
      <SelectedSpan recording={recording} review={review} />
      <Questions recording={recording} review={review} />
      <Proposals recording={recording} review={review} />
      <LearnedPart recording={recording} review={review} />
      {review.omissions.length > 0 && (
        <section>
          <h3>Left out</h3>
          <ul class="tiny">
            {review.omissions.map((each) => (
              <li key={each}>{each}</li>
            ))}
          </ul>
        </section>
      )}
    </aside>
  );
}

function SelectedSpan({ recording, review }: PaneProps) {
  const { selected } = recording;
  const span = selected === null ? undefined : recording.spanAt(selected.first);
  const drives = recording.busy === "drive";
  const now = drives ? review.spans.at(-1)?.label : undefined;
  const whole =
    span !== undefined && selected !== null && span.end === selected.end && span.first === selected.first;
  return (
    <section>
      <h3>{selected === null ? "Labels" : recording.period(selected)}</h3>
      {span !== undefined && (
        <p class="soft">
          {whole
            ? `${plain(review.labels[span.label] ?? "")}, ${span.by_hand ? "set by hand" : `${(100 * span.certainty).toFixed(0)} % certain`}. What was it?`
            : "What was this part?"}
        </p>
      )}
      <div class="labels">
        {review.labels.map((label, index) => {
          const none = index === review.labels.length - 1;
          return (
            <Button
              key={label}
              disabled={selected === null || recording.busy !== null}
              class={className("flex", "label", ((whole && span.label === index) || now === index) && "on")}
              aria-pressed={whole && span.label === index}
              onClick={() => void recording.label(index)}
            >
              <Swatch label={index} review={review} />
              <span class="cut">{nameLabel(review, index)}</span>
              {(none || index < 9) && <kbd>{none ? 0 : index + 1}</kbd>}
            </Button>
          );
        })}
      </div>
      {selected === null && recording.busy === null && (
        <p class="tiny soft">Select a span on the timeline, or press →, to change its label.</p>
      )}
    </section>
  );
}

function Questions({ recording, review }: PaneProps) {
  if (review.questions.length === 0) return null;
  return (
    <section>
      <h3>In doubt</h3>
      <ul class="questions">
        {review.questions.map((question) => (
          <li key={question.first}>
            <Button class="link" onClick={() => recording.select(question)}>
              {recording.period(question)}
            </Button>
            <div class="answers">
              {question.labels.map((label, index) => (
                <ReviewButton
                  key={label}
                  recording={recording}
                  request={{
                    do: "label",
                    first: question.first,
                    end: question.end,
                    label: review.labels[label] ?? "",
                  }}
                >
                  <Swatch label={label} review={review} />
                  {nameLabel(review, label)}
                  <span class="soft"> {(100 * (question.chances[index] ?? 0)).toFixed(0)} %</span>
                </ReviewButton>
              ))}
            </div>
          </li>
        ))}
      </ul>
      <p class="tiny soft">Switches to and from these are left out of the lesson until you answer.</p>
    </section>
  );
}

/** Commands that nothing explains, but that recur: each can become a behavior. */
function Proposals({ recording, review }: PaneProps) {
  if (review.proposals.length === 0) return null;
  return (
    <section>
      <h3>Not explained</h3>
      <ul class="questions">
        {review.proposals.map((proposal) => (
          <Proposal key={proposal.description} recording={recording} proposal={proposal} />
        ))}
      </ul>
      <p class="tiny soft">A behavior with these commands explains them once it has a name.</p>
    </section>
  );
}

function Proposal({ recording, proposal }: { recording: Recording; proposal: BehaviorProposal }) {
  const [name, setName] = useState("");
  return (
    <li>
      <b>{plain(proposal.description)}</b>
      <p class="tiny soft">
        {proposal.seconds.toFixed(1)} s in {formatCount(proposal.spans, "span")}, the longest{" "}
        <Button class="link" onClick={() => recording.select(proposal)}>
          {recording.period(proposal)}
        </Button>
      </p>
      <Form class="save" submit={() => void recording.ask({ do: "define", name, command: proposal.command })}>
        <label>
          Name of the behavior
          <Input value={name} change={(text) => setName(text.trim())} required maxLength={150} />
        </label>
        <ReviewButton recording={recording} disabled={name === ""}>
          Add
        </ReviewButton>
      </Form>
    </li>
  );
}

/** States that end in ways which no feature tells apart, but the state before does. */
function Splits({ recording, learned }: { recording: Recording; learned: LearnedDrive }) {
  return (
    <>
      {learned.splits.map((split) => (
        <div key={split.state} class="split">
          <p>{plain(split.evidence.charAt(0).toUpperCase() + split.evidence.slice(1))}.</p>
          <ReviewButton
            recording={recording}
            request={{ do: "split", state: split.state, entered_from: split.entered_from }}
          >
            Split {plain(split.state)} in two
          </ReviewButton>
        </div>
      ))}
    </>
  );
}

function LearnedPart({ recording, review }: PaneProps) {
  const { learned } = review;
  return (
    <section>
      <h3>Automaton</h3>
      {learned === null ? (
        <ReviewButton class="primary" recording={recording} request={{ do: "learn" }}>
          {recording.busy === "learn" ? "Learning …" : "Learn from these labels"}
        </ReviewButton>
      ) : (
        <>
          <Result learned={learned} />
          <Contradictions recording={recording} review={review} learned={learned} />
          <Splits recording={recording} learned={learned} />
          <Save recording={recording} review={review} />
        </>
      )}
    </section>
  );
}

function Result({ learned }: { learned: LearnedDrive }) {
  return (
    <>
      <p>
        It repeats <b>{(100 * learned.unseen).toFixed(1)} %</b>: {learned.repeats_unseen}. Run over the
        recording, it does as labeled at <b>{(100 * learned.agreement).toFixed(1)} %</b> of all ticks:{" "}
        {learned.repeats}.
      </p>
      <p class="tiny soft">
        {formatCount(learned.examples, "example")}
        {learned.quarantined > 0 && `, ${learned.quarantined} left out as doubtful or contradicted`}.
        {learned.reactions.map((each) => ` ${each}`)}
      </p>
      <ul class="rules">
        {learned.edges.map((edge) => (
          <li key={`${edge.from} ${edge.to}`}>
            <b>
              {plain(edge.from)} → {plain(edge.to)}
            </b>
            {edge.when.map((each) => (
              <p key={each} class="condition">
                {plain(each)}
              </p>
            ))}
          </li>
        ))}
      </ul>
    </>
  );
}

function Save({ recording, review }: PaneProps) {
  const [name, setName] = useState(review.name);
  return (
    <>
      <Form class="save" submit={() => void recording.ask({ do: "save", name })}>
        <label>
          Name
          <Input value={name} change={setName} required maxLength={150} />
        </label>
        <ReviewButton class="primary" recording={recording} disabled={name === ""}>
          Save
        </ReviewButton>
      </Form>
      {review.saved !== null && (
        <p class="saved" role="status">
          Saved in {review.saved}
        </p>
      )}
    </>
  );
}
