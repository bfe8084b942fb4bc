/** A lesson that was cut off before it was saved: resume it, or throw it away, which can be taken back. */

import { ControlButton } from "../button";
import { useStudio } from "../context";
import type { InterruptedSession } from "../protocol";
import { formatCount, plain } from "../words";
import { useOpenAction } from "./openaction";

export function InterruptedLesson({ left }: { left: InterruptedSession }) {
  const studio = useStudio();
  const { name, examples } = left;
  const { open, asks } = useOpenAction(studio, name);
  return (
    <li class="card behavior">
      <div class="flex behavior-head">
        <b>{plain(name)}</b>
        <span class="space" />
        <ControlButton class="small" aria-label={`Resume ${name}`} onClick={open}>
          Resume
        </ControlButton>
        <Discard name={name} />
      </div>
      <p class="tiny">interrupted before it was saved, with {formatCount(examples, "example")}</p>
      {asks}
    </li>
  );
}

export function Discard({ name }: { name: string }) {
  return (
    <ControlButton
      class="small danger"
      aria-label={`Discard the interrupted lesson of ${name}`}
      request={{ do: "discard", name }}
      back={{ do: "recall", name }}
    >
      Discard
    </ControlButton>
  );
}
