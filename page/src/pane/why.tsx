/** The explanation of the present decision: for each level, its conditions and the examples behind it. */

import { useEffect, useRef, useState } from "preact/hooks";
import { Button, CloseButton, ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import { useSlowNews } from "../news";
import type { Answer, DecisionBasis, Level, ResponsibleExample } from "../protocol";
import { formatTime, plain } from "../words";
import { KindSign } from "./examples";

const EVERY_MS = 300;

export function Why() {
  const studio = useStudio();
  const panel = usePanel();
  const name = studio.session?.name ?? null;
  const isOpen = name !== null && panel.why === name;
  return (
    <div class="why">
      <Button
        class="small"
        aria-expanded={isOpen}
        title="Explains what it decides now, and why it last switched"
        onClick={() => panel.askWhy(isOpen ? null : name)}
      >
        why?
      </Button>
      <ControlButton
        class="small"
        title="The automaton from its start state, the robot where it is"
        request={{ do: "restart" }}
      >
        Restart automaton
      </ControlButton>
      {isOpen && <Reasons close={() => panel.askWhy(null)} />}
    </div>
  );
}

/** The reasons of the moment that is shown, asked for again whenever it is another. */
function Reasons({ close }: { close: () => void }) {
  const studio = useStudio();
  useSlowNews(studio.framed, EVERY_MS);
  const [answer, setAnswer] = useState<Answer | null>(null);
  const { session, runHistory } = studio;
  const now = [
    runHistory.now,
    session?.state,
    session?.mode,
    session?.edition,
    session?.pending,
    studio.status?.run.number,
  ].join();
  const lastState = useRef(now);
  const waiting = useRef(false);
  lastState.current = now;
  useEffect(() => {
    const look = async (): Promise<void> => {
      if (waiting.current) return; // the last moment counts, when the server is ready for it
      waiting.current = true;
      let state = "";
      while (state !== lastState.current) {
        state = lastState.current;
        setAnswer(await studio.ask({ do: "why" }));
      }
      waiting.current = false;
    };
    void look();
  }, [now]);
  if (answer === null || answer.levels === undefined) return null;
  const { levels, last } = answer;
  return (
    <section class="reasons" aria-label="Why">
      <CloseButton class="link close" label="Close the explanation" onClick={close} />
      {levels.map((level, depth) => (
        <div key={depth} class="reason" style={{ marginLeft: `${9 * depth}px` }}>
          <p class="tiny">
            <b>{plain(level.automaton)}</b> in {plain(level.state)} since {formatTime(level.since_s)}
          </p>
          <p>
            {level.in_training && "In training, you decide. In testing: "}
            {plain(describeDecision(level))}
          </p>
          <BasisView basis={level} />
        </div>
      ))}
      {last !== null && last !== undefined && (
        <div class="reason last">
          <p class="tiny">
            the last switch, at {formatTime(last.time_s)}, of <b>{plain(last.automaton)}</b>
          </p>
          <p>{plain(last.decision)}</p>
          <BasisView basis={last} />
        </div>
      )}
    </section>
  );
}

function describeDecision({ decision, in_training }: Level): string {
  return in_training && decision.startsWith("It ") ? `it ${decision.slice(3)}` : decision;
}

/** What it read, and the examples responsible, with when they were shown: a click opens one in the lesson. */
function BasisView({ basis }: { basis: DecisionBasis }) {
  const panel = usePanel();
  const { automaton, readings, by_hand: byHand, in_lesson, examples, omitted } = basis;
  const behavior = automaton.replace(/\(.*/, "");
  return (
    <>
      {readings !== "" && <p class="tiny">it read {plain(readings)}</p>}
      {byHand && <p class="tiny">It was written by hand: no example is behind it.</p>}
      {examples.length > 0 && (
        <p class="tiny responsible">
          shown by{" "}
          {examples.map((example) =>
            in_lesson ? (
              <Button
                key={example.number}
                class="link"
                title={`Open example ${example.number} in the lesson`}
                onClick={() => panel.openExample(example.number)}
              >
                <ExampleLink example={example} />
              </Button>
            ) : (
              <span key={example.number}>
                <ExampleLink example={example} />
              </span>
            ),
          )}
          {omitted > 0 && <span>and {omitted} more</span>}
          {!in_lesson && (
            <Button class="link" onClick={() => panel.showBehavior(behavior)}>
              of {plain(behavior)}
            </Button>
          )}
        </p>
      )}
    </>
  );
}

/** An example by its number, how it came about, and when. */
function ExampleLink({ example }: { example: ResponsibleExample }) {
  return (
    <>
      {example.number} <KindSign example={example} />
      {example.time_s !== null && <span class="soft"> {formatTime(example.time_s)}</span>}
    </>
  );
}
