/** The question of a robot that is unsure, and waits: under the world, above the buttons that are the answer. */

import { useEffect, useRef } from "preact/hooks";
import { ControlButton } from "./button";
import { useStudio } from "./context";
import { isNewQuestion, playQuestion, soundIsOn, type QuestionState } from "./sound";
import { plain } from "./words";

/** How many other answers are offered beside the likeliest. */
const OTHERS = 2;

export function QuestionCard() {
  const studio = useStudio();
  const { session } = studio;
  const question = session?.queries.question ?? null;
  useSound({ question: question?.sentence ?? null, marks: session?.queries.marks.length ?? 0 });
  if (session === null || question === null) return null;
  const stays = question.next === session.state;
  const others = question.answers.filter((each) => each !== question.next).slice(0, OTHERS);
  const answer = (state: string, event: MouseEvent): void => {
    void (state === session.state ? studio.confirm(event.timeStamp) : studio.press(state, event.timeStamp));
  };
  return (
    <section class="flex wrap question-card" role="status" aria-label="Question of the robot">
      <p>
        {plain(question.sentence)} <span class="soft">Press it below.</span>
      </p>
      <p class="choices">
        <ControlButton class="small primary" onClick={(event) => answer(question.next, event)}>
          {stays ? `Yes, stay in ${plain(session.state)}` : `Yes, go to ${plain(question.next)}`}
        </ControlButton>
        {others.map((each) => (
          <ControlButton key={each} class="small" onClick={(event) => answer(each, event)}>
            {each === session.state ? `No, stay in ${plain(each)}` : `No, ${plain(each)}`}
          </ControlButton>
        ))}
        <ControlButton
          class="small"
          title="Without an answer: nothing is recorded"
          request={{ do: "pause", paused: false }}
        >
          Carry on
        </ControlButton>
      </p>
    </section>
  );
}

/** Play the sound of a question when there is a new one, if that is wanted. */
function useSound(now: QuestionState): void {
  const before = useRef(now);
  useEffect(() => {
    if (isNewQuestion(now, before.current) && soundIsOn()) playQuestion();
    before.current = now;
  });
}
