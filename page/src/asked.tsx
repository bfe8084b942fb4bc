/** The question of a robot that is unsure, and waits: under the world, above the buttons that are the answer. */

import { useStudio } from "./context";

export function Asked() {
  const studio = useStudio();
  const { desk } = studio;
  const question = desk?.asking.question ?? null;
  if (desk === null || question === null) return null;
  const stays = question.next === desk.state;
  const agree = (event: MouseEvent): void => {
    void (stays ? studio.confirm(event.timeStamp) : studio.press(question.next, event.timeStamp));
  };
  return (
    <section class="asked" role="status" aria-label="Question of the robot">
      <p>
        {question.sentence} <span class="soft">Press it below.</span>
      </p>
      <p class="choices">
        <button type="button" class="small primary" disabled={!studio.directs} onClick={agree}>
          {stays ? `Yes, stay in ${desk.state}` : `Yes, go to ${question.next}`}
        </button>
        <button
          type="button"
          class="small"
          disabled={!studio.directs}
          title="Without an answer: nothing is recorded"
          onClick={() => void studio.ask({ do: "pause", paused: false })}
        >
          Carry on
        </button>
      </p>
    </section>
  );
}
