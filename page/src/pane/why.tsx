/** Why it does what it does: every level, what held there, and who showed it; it goes along with time. */

import { useEffect, useRef, useState } from "preact/hooks";
import { usePanel, useStudio } from "../context";
import { useSlowNews } from "../news";
import type { Answer, Behind, Level, Responsible } from "../protocol";
import type { Studio } from "../studio";
import { formatTime, plain } from "../words";
import { KINDS, kindOf } from "./examples";

const EVERY_MS = 300;

export function Why() {
  const studio = useStudio();
  const panel = usePanel();
  const name = studio.desk?.name ?? null;
  const isOpen = name !== null && panel.why === name;
  return (
    <div class="why">
      <button
        type="button"
        class="small"
        aria-expanded={isOpen}
        title="Explains what it decides now, and why it last switched"
        onClick={() => panel.askWhy(isOpen ? null : name)}
      >
        why?
      </button>
      <button
        type="button"
        class="small"
        disabled={!studio.directs}
        title="The automaton from its start state, the robot where it is"
        onClick={() => void studio.ask({ do: "restart" })}
      >
        Restart automaton
      </button>
      {isOpen && <Reasons studio={studio} close={() => panel.askWhy(null)} />}
    </div>
  );
}

/** The reasons of the moment that is shown, asked for again whenever it is another. */
function Reasons({ studio, close }: { studio: Studio; close: () => void }) {
  useSlowNews(studio.framed, EVERY_MS);
  const [answer, setAnswer] = useState<Answer | null>(null);
  const { desk, runHistory } = studio;
  const now = [
    runHistory.now,
    desk?.state,
    desk?.mode,
    desk?.edition,
    desk?.waiting,
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
      <button type="button" class="link close" aria-label="Close the explanation" onClick={close}>
        ×
      </button>
      {levels.map((level, depth) => (
        <div key={depth} class="reason" style={{ marginLeft: `${9 * depth}px` }}>
          <p class="tiny">
            <b>{plain(level.automaton)}</b> in {plain(level.state)} since {formatTime(level.since_s)}
          </p>
          <p>
            {level.yours && "In training, you decide. In testing: "}
            {plain(describeDecision(level))}
          </p>
          <BehindIt behind={level} />
        </div>
      ))}
      {last !== null && last !== undefined && (
        <div class="reason last">
          <p class="tiny">
            the last switch, at {formatTime(last.time_s)}, of <b>{plain(last.automaton)}</b>
          </p>
          <p>{plain(last.says)}</p>
          <BehindIt behind={last} />
        </div>
      )}
    </section>
  );
}

function describeDecision({ says: decision, yours }: Level): string {
  return yours && decision.startsWith("It ") ? `it ${decision.slice(3)}` : decision;
}

/** What it read, and the examples responsible, with when they were shown: a click opens one in the lesson. */
function BehindIt({ behind }: { behind: Behind }) {
  const panel = usePanel();
  const { automaton, read, by_hand: byHand, here, examples, more } = behind;
  const behavior = automaton.replace(/\(.*/, "");
  return (
    <>
      {read !== "" && <p class="tiny">it read {plain(read)}</p>}
      {byHand && <p class="tiny">It was written by hand: no example is behind it.</p>}
      {examples.length > 0 && (
        <p class="tiny responsible">
          shown by{" "}
          {examples.map((example) =>
            here ? (
              <button
                type="button"
                key={example.number}
                class="link"
                title={`Open example ${example.number} in the lesson`}
                onClick={() => panel.openExample(example.number)}
              >
                <ExampleLink example={example} />
              </button>
            ) : (
              <span key={example.number}>
                <ExampleLink example={example} />
              </span>
            ),
          )}
          {more > 0 && <span>and {more} more</span>}
          {!here && (
            <button type="button" class="link" onClick={() => panel.showBehavior(behavior)}>
              of {plain(behavior)}
            </button>
          )}
        </p>
      )}
    </>
  );
}

/** An example by its number, how it came about, and when. */
function ExampleLink({ example }: { example: Responsible }) {
  const [sign, word] = KINDS[kindOf(example)];
  return (
    <>
      {example.number}{" "}
      <span role="img" aria-label={word} title={word}>
        {sign}
      </span>
      {example.time_s !== null && <span class="soft"> {formatTime(example.time_s)}</span>}
    </>
  );
}
