/** The question of a robot that is unsure, and waits: under the world, above the buttons that are the answer. */

import { useEffect, useRef } from "preact/hooks";
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
    <section class="question-card" role="status" aria-label="Question of the robot">
      <p>
        {plain(question.sentence)} <span class="soft">Press it below.</span>
      </p>
      <p class="choices">
        <button
          type="button"
          class="small primary"
          disabled={!studio.hasControl}
          onClick={(event) => answer(question.next, event)}
        >
          {stays ? `Yes, stay in ${plain(session.state)}` : `Yes, go to ${plain(question.next)}`}
        </button>
        {others.map((each) => (
          <button
            key={each}
            type="button"
            class="small"
            disabled={!studio.hasControl}
            onClick={(event) => answer(each, event)}
          >
            {each === session.state ? `No, stay in ${plain(each)}` : `No, ${plain(each)}`}
          </button>
        ))}
        <button
          type="button"
          class="small"
          disabled={!studio.hasControl}
          title="Without an answer: nothing is recorded"
          onClick={() => void studio.ask({ do: "pause", paused: false })}
        >
          Carry on
        </button>
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
