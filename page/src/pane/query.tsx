/** Whether the robot asks where it is unsure, and the moments it marked. */

import { useState } from "preact/hooks";
import { ControlButton } from "../button";
import { useStudio } from "../context";
import { Option } from "../fields";
import { KeyName } from "../keyname";
import type { QueryPolicy, Session } from "../protocol";
import { soundIsOn, turnSound } from "../sound";
import { formatTime, plain } from "../words";

const WAYS: Readonly<Record<QueryPolicy, readonly [name: string, about: string]>> = {
  never: ["no", "Never asks."],
  pause: ["pause", "Pauses when unsure; your next press answers."],
  mark: ["mark", "It goes on where it is unsure, and marks the moment here and on the time line."],
};

export function QueryPart({ session }: { session: Session }) {
  const studio = useStudio();
  const { policy, marks } = session.queries;
  return (
    <section class="query" aria-label="Asking">
      <div class="flex ask-when">
        <span id="ask-when">Ask when unsure</span>
        <div class="segments ways" role="group" aria-labelledby="ask-when">
          {(Object.keys(WAYS) as QueryPolicy[]).map((each) => (
            <ControlButton
              key={each}
              aria-pressed={policy === each}
              title={WAYS[each][1]}
              onClick={() => void (policy !== each && studio.ask({ do: "set_query_policy", policy: each }))}
            >
              {WAYS[each][0]}
            </ControlButton>
          ))}
        </div>
      </div>
      <p class="tiny">{WAYS[policy][1]}</p>
      {session.mode !== "training" && session.presses > 0 && (
        <ControlButton
          class="small"
          title="In a new world, where your answer would change most of what the robot does"
          request={{ do: "next_situation" }}
        >
          Go to where an answer matters most <KeyName place="KeyG" shift />
        </ControlButton>
      )}
      {policy !== "never" && <SoundChoice />}
      {marks.length > 0 && (
        <ol class="unsure-marks" aria-label="Moments at which it was unsure">
          {[...marks].reverse().map(({ number, time_s, run, sentence }) => (
            <li key={number}>
              <ControlButton
                class="link number"
                title="Go back to this moment, and answer"
                request={{ do: "go_to_mark", number }}
              >
                {formatTime(time_s)}
              </ControlButton>
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
  const turn = (wanted: boolean) => {
    turnSound(wanted);
    setOn(wanted);
  };
  return (
    <Option checked={on} change={turn}>
      Sound when it asks
    </Option>
  );
}
