/** Why it does what it does: every level, what held there, and who showed it; it goes along with time. */

import { useEffect, useRef, useState } from "preact/hooks";
import { usePanel, useStudio } from "../context";
import { useSlowNews } from "../news";
import type { Answer, Behind, Level, Responsible } from "../protocol";
import type { Studio } from "../studio";
import { clock, plain } from "../words";
import { KINDS, kindOf } from "./examples";

const EVERY_MS = 300;

export function Why() {
  const studio = useStudio();
  const panel = usePanel();
  const name = studio.desk?.name ?? null;
  const asked = name !== null && panel.why === name;
  return (
    <div class="why">
      <button
        type="button"
        class="small"
        aria-expanded={asked}
        title="Explains what it decides now, and why it last switched"
        onClick={() => panel.askWhy(asked ? null : name)}
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
      {asked && <Reasons studio={studio} close={() => panel.askWhy(null)} />}
    </div>
  );
}

/** The reasons of the moment that is shown, asked for again whenever it is another. */
function Reasons({ studio, close }: { studio: Studio; close: () => void }) {
  useSlowNews(studio.framed, EVERY_MS);
  const [told, setTold] = useState<Answer | null>(null);
  const { desk, past } = studio;
  const now = [
    past.now,
    desk?.state,
    desk?.mode,
    desk?.edition,
    desk?.waiting,
    studio.told?.run.number,
  ].join();
  const shown = useRef(now);
  const waiting = useRef(false);
  shown.current = now;
  useEffect(() => {
    const look = async (): Promise<void> => {
      if (waiting.current) return; // the last moment counts, when the server is ready for it
      waiting.current = true;
      let asked = "";
      while (asked !== shown.current) {
        asked = shown.current;
        setTold(await studio.ask({ do: "why" }));
      }
      waiting.current = false;
    };
    void look();
  }, [now]);
  if (told === null || told.levels === undefined) return null;
  const { levels, last } = told;
  return (
    <section class="reasons" aria-label="Why">
      <button type="button" class="link close" aria-label="Close the explanation" onClick={close}>
        ×
      </button>
      {levels.map((level, depth) => (
        <div key={depth} class="reason" style={{ marginLeft: `${9 * depth}px` }}>
          <p class="tiny">
            <b>{plain(level.automaton)}</b> in {plain(level.state)} since {clock(level.since_s)}
          </p>
          <p>
            {level.yours && "In training, you decide. In testing: "}
            {plain(says(level))}
          </p>
          <BehindIt behind={level} />
        </div>
      ))}
      {last !== null && last !== undefined && (
        <div class="reason last">
          <p class="tiny">
            the last switch, at {clock(last.time_s)}, of <b>{plain(last.automaton)}</b>
          </p>
          <p>{plain(last.says)}</p>
          <BehindIt behind={last} />
        </div>
      )}
    </section>
  );
}

function says({ says: said, yours }: Level): string {
  return yours && said.startsWith("It ") ? `it ${said.slice(3)}` : said;
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
                <Shown example={example} />
              </button>
            ) : (
              <span key={example.number}>
                <Shown example={example} />
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
function Shown({ example }: { example: Responsible }) {
  const [sign, word] = KINDS[kindOf(example)];
  return (
    <>
      {example.number}{" "}
      <span role="img" aria-label={word} title={word}>
        {sign}
      </span>
      {example.time_s !== null && <span class="soft"> {clock(example.time_s)}</span>}
    </>
  );
}
