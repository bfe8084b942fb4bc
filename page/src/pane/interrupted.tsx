/** A lesson that was cut off before it was saved: resume it, or throw it away, which can be taken back. */

import type { InterruptedSession } from "../protocol";
import type { Studio } from "../studio";
import { formatCount, plain } from "../words";
import { useOpenAction } from "./openaction";

export function InterruptedLesson({ left, studio }: { left: InterruptedSession; studio: Studio }) {
  const { name, examples } = left;
  const { open, asks } = useOpenAction(studio, name);
  return (
    <li class="behavior">
      <div class="behavior-head">
        <b>{plain(name)}</b>
        <span class="space" />
        <button
          type="button"
          class="small"
          aria-label={`Resume ${name}`}
          disabled={!studio.hasControl}
          onClick={open}
        >
          Resume
        </button>
        <Discard name={name} studio={studio} />
      </div>
      <p class="tiny">interrupted before it was saved, with {formatCount(examples, "example")}</p>
      {asks}
    </li>
  );
}

export function Discard({ name, studio }: { name: string; studio: Studio }) {
  return (
    <button
      type="button"
      class="small danger"
      aria-label={`Discard the interrupted lesson of ${name}`}
      disabled={!studio.hasControl}
      onClick={() => void studio.change({ do: "discard", name }, { do: "recall", name })}
    >
      Discard
    </button>
  );
}
