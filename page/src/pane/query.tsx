/** Whether the robot asks where it is unsure, and the moments it marked. */

import { useState } from "preact/hooks";
import type { AskWhenName, Session } from "../protocol";
import { soundIsOn, turnSound } from "../sound";
import type { Studio } from "../studio";
import { formatTime, plain } from "../words";

const WAYS: Readonly<Record<AskWhenName, readonly [name: string, about: string]>> = {
  never: ["no", "Never asks."],
  pause: ["pause", "Pauses when unsure; your next press answers."],
  mark: ["mark", "It goes on where it is unsure, and marks the moment here and on the time line."],
};

export function QueryPart({ desk, studio }: { desk: Session; studio: Studio }) {
  const { when, marks } = desk.asking;
  return (
    <section class="query" aria-label="Asking">
      <div class="ask-when">
        <span id="ask-when">Ask when unsure</span>
        <div class="ways" role="group" aria-labelledby="ask-when">
          {(Object.keys(WAYS) as AskWhenName[]).map((each) => (
            <button
              type="button"
              key={each}
              aria-pressed={when === each}
              disabled={!studio.directs}
              title={WAYS[each][1]}
              onClick={() => void (when !== each && studio.ask({ do: "ask_when", when: each }))}
            >
              {WAYS[each][0]}
            </button>
          ))}
        </div>
      </div>
      <p class="tiny">{WAYS[when][1]}</p>
      {desk.mode !== "training" && desk.taught > 0 && (
        <button
          type="button"
          class="small"
          disabled={!studio.directs}
          title="In a new world, where your answer would change most of what the robot does"
          onClick={() => void studio.ask({ do: "next_situation" })}
        >
          Go to where an answer matters most <kbd>G</kbd>
        </button>
      )}
      {when !== "never" && <SoundChoice />}
      {marks.length > 0 && (
        <ol class="unsure-marks" aria-label="Moments at which it was unsure">
          {[...marks].reverse().map(({ number, time_s, run, sentence }) => (
            <li key={number}>
              <button
                type="button"
                class="link"
                disabled={!studio.directs}
                title="Go back to this moment, and answer"
                onClick={() => void studio.ask({ do: "go_to_mark", number })}
              >
                {formatTime(time_s)}
              </button>
              <span>
                {run !== studio.status?.run.number && <span class="soft">in an earlier run: </span>}
                {plain(sentence.replace(/^I am not sure: | What is right\?$/g, ""))}
              </span>
            </li>
          ))}
        </ol>
      )}
    </section>
  );
}

function SoundChoice() {
  const [on, setOn] = useState(soundIsOn());
  const turn = () => {
    turnSound(!on);
    setOn(!on);
  };
  return (
    <label class="option">
      <input type="checkbox" checked={on} onChange={turn} /> Sound when it asks
    </label>
  );
}
