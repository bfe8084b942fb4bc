/** The tab Coach: whether the robot asks, how late presses come, what to show next, and where behaviors failed. */

import { useEffect, useRef, useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import { Select } from "../fields";
import { useFirst } from "../lists";
import type { Advice, Finding, ReactionEstimate, Session } from "../protocol";
import type { Studio } from "../studio";
import { className, plain } from "../words";
import { QueryPart } from "./query";
import { FailuresPart } from "./failures";
import { PropertiesPart } from "./properties";

/** The time between two questions to the coach, since a watched lesson changes all the time. */
const REST_MS = 1_000;
/** The time after which the page looks again for an answer, which takes longer for a large lesson. */
const AGAIN_MS = 300;
const FIRST = 8;
/** From here on it is plainly worth following. */
const PLAIN = 0.5;
/** What a change of the features would settle. */
const OF_FEATURES: ReadonlySet<string> = new Set(["separating", "disagreement", "idle"]);

export function CoachTab() {
  const studio = useStudio();
  const { session } = studio;
  if (session === null) {
    return (
      <>
        <p class="empty">Suggestions for your next demonstrations appear here.</p>
        <FailuresPart />
        <PropertiesPart />
      </>
    );
  }
  return (
    <>
      <QueryPart session={session} />
      <FailuresPart />
      <PropertiesPart />
      <CoachReportView key={session.name} session={session} />
    </>
  );
}

interface CoachReport {
  advice: readonly Advice[];
  findings: readonly Finding[];
  late: ReactionEstimate | null;
}

/** What the coach says of the lesson; asked again when that has changed, and when its score is taken. */
function useCoach(
  studio: Studio,
  edition: number,
  scoring: boolean,
): readonly [CoachReport | null, () => void] {
  const [report, setReport] = useState<CoachReport | null>(null);
  const [requests, setRequests] = useState(0);
  const last = useRef(-REST_MS);
  useEffect(() => {
    let over = false;
    let due = setTimeout(() => void ask(), last.current + REST_MS - performance.now());
    const ask = async (): Promise<void> => {
      last.current = performance.now();
      const { advice, findings, reaction, later } = await studio.ask({ do: "request_advice" });
      if (over) return;
      if (later === true) due = setTimeout(() => void ask(), AGAIN_MS);
      if (advice !== undefined) setReport({ advice, findings: findings ?? [], late: reaction ?? null });
    };
    return () => {
      over = true;
      clearTimeout(due);
    };
  }, [edition, scoring, requests]);
  const again = (): void => {
    last.current = -REST_MS;
    setRequests((count) => count + 1);
  };
  return [report, again];
}

interface SessionProps {
  session: Session;
}

function CoachReportView({ session }: SessionProps) {
  const studio = useStudio();
  const [report, again] = useCoach(studio, session.edition, session.score.running);
  const [listed, more] = useFirst(report?.advice ?? [], FIRST, (hidden) => `${hidden} more, less useful`);
  const [setUp, setSetUp] = useState<{ of: string; outcome: string; run: number } | null>(null);
  if (report === null) return null;
  const { advice, findings, late } = report;
  const there = setUp !== null && (studio.status?.run.number ?? 0) <= setUp.run ? setUp : null; // else it is elsewhere by now
  const place = async (of: string): Promise<void> => {
    const { sentence, run } = await studio.ask({ do: "set_up", sentence: of });
    if (sentence !== undefined && run !== undefined) setSetUp({ of, outcome: sentence, run });
  };
  return (
    <>
      {late !== null && <ReactionCard late={late} />}
      <h3>What to show next</h3>
      {advice.length === 0 && <p class="empty">No suggestions: the lesson is consistent.</p>}
      <ol aria-label="Advice">
        {listed.map((each) => (
          <AdviceItem
            key={each.sentence}
            advice={each}
            session={session}
            again={again}
            outcome={there?.of === each.sentence ? there.outcome : null}
            setUp={() => void place(each.sentence)}
          />
        ))}
      </ol>
      {more}
      {findings.length > 0 && <h3>What a check finds</h3>}
      <ol aria-label="Findings">
        {findings.map((each) => (
          <FindingRow
            key={each.sentence}
            finding={each}
            outcome={there?.of === each.sentence ? there.outcome : null}
            setUp={() => void place(each.sentence)}
          />
        ))}
      </ol>
    </>
  );
}

interface FindingRowProps {
  finding: Finding;
  /** What came of setting it up, where that was the last. */
  outcome: string | null;
  setUp: () => void;
}

/** What the automaton cannot do, or does without end, by its trees alone. */
function FindingRow({ finding, outcome, setUp }: FindingRowProps) {
  const panel = usePanel();
  const { error, sentence, remedy, assumptions, examples, can_set_up } = finding;
  return (
    <li
      class={className("card", "advice", "finding", "important", error && "error", outcome !== null && "on")}
    >
      <div class="advice-head">
        <p>
          <b>{error ? "Error" : "Warning"}:</b> {plain(sentence)}
        </p>
        {can_set_up && <SetUpButton setUp={setUp} />}
      </div>
      <p class="remedy">{plain(remedy)}</p>
      {assumptions.map((each) => (
        <p key={each} class="assumed">
          Assumes: {plain(each)}
        </p>
      ))}
      {examples.length > 0 && (
        <p class="more">
          <Button class="link" onClick={() => panel.showExamples(examples)}>
            show {examples.length === 1 ? `example ${examples[0]}` : `${examples.length} examples`}
          </Button>
        </p>
      )}
      {outcome !== null && <p class="outcome">{plain(outcome)}</p>}
    </li>
  );
}

function SetUpButton({ setUp }: { setUp: () => void }) {
  return (
    <ControlButton
      class="small"
      title="Put the robot into this situation; nothing is recorded"
      onClick={setUp}
    >
      Set up
    </ControlButton>
  );
}

interface ItemProps {
  advice: Advice;
  session: Session;
  /** Ask the coach again, where the lesson has not changed. */
  again: () => void;
  /** What came of setting it up, where that was the last. */
  outcome: string | null;
  setUp: () => void;
}

function AdviceItem({ advice, session, again, outcome, setUp }: ItemProps) {
  const panel = usePanel();
  const { sentence, evidence, examples, slip, kind, weight, can_set_up } = advice;
  const show = (): void => {
    const [number] = examples;
    panel.showExamples(examples);
    if ((examples.length === 1 || slip !== null) && number !== undefined) panel.selectExample(number);
  };
  return (
    <li
      class={className(
        "card",
        "advice",
        (weight > PLAIN || kind === "few") && "important",
        outcome !== null && "on",
      )}
    >
      <div class="advice-head">
        <p>{plain(sentence)}</p>
        {can_set_up && <SetUpButton setUp={setUp} />}
      </div>
      {evidence !== "" && <p class="tiny">{plain(evidence)}</p>}
      {slip !== null && (
        <SlipQuestion number={examples[0] ?? 0} says={slip} session={session} again={again} />
      )}
      <p class="more">
        {examples.length > 0 && (
          <Button class="link" onClick={show}>
            show{" "}
            {examples.length === 1 || slip !== null
              ? `example ${examples[0]}`
              : `${examples.length} examples`}
          </Button>
        )}
        {OF_FEATURES.has(kind) && (
          <ControlButton class="link" onClick={() => panel.choose("choose")}>
            choose features
          </ControlButton>
        )}
      </p>
      {outcome !== null && <p class="outcome">{plain(outcome)}</p>}
    </li>
  );
}

interface SlipQuestionProps extends SessionProps {
  number: number;
  says: { state: string; next: string };
  again: () => void;
}

/** Whether a press that looks like a slip was meant, and if not, what was. */
function SlipQuestion({ number, says, session, again }: SlipQuestionProps) {
  const studio = useStudio();
  const others = session.states.slice(1).flatMap(({ name }) => (name === says.next ? [] : [name]));
  const correct = (next: string): void => {
    if (next !== "") void studio.change({ do: "correct_slip", number, next }, { do: "undo" });
  };
  const confirm = async (): Promise<void> => {
    await studio.ask({ do: "confirm_press", number });
    again();
  };
  return (
    <p class="choices">
      <ControlButton class="small" onClick={() => void confirm()}>
        Yes, I meant {plain(says.next)}
      </ControlButton>
      <Select
        aria-label={`What example ${number} was meant to say`}
        class="small"
        disabled={!studio.hasControl}
        value=""
        among={[
          ["", "No, I meant …"],
          ...others.map((name) => (name === says.state ? ([name, `stay in ${plain(name)}`] as const) : name)),
        ]}
        change={correct}
      />
    </p>
  );
}

function ReactionCard({ late }: { late: ReactionEstimate }) {
  const { reaction_s, sentence } = late;
  return (
    <section class="card advice important late" aria-label="Reaction time">
      <p>{plain(sentence)}</p>
      <p class="choices">
        <ControlButton
          class="small primary"
          title="Shift all presses earlier by this much (can be undone)"
          request={{ do: "set_reaction_time", reaction_s }}
          back={{ do: "undo" }}
        >
          Use {reaction_s} s
        </ControlButton>
      </p>
    </section>
  );
}
