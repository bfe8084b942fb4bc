/** Opening an automaton: what would be left behind is asked in place, never over the running world. */

import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { Button } from "../button";
import { usePanel } from "../context";
import type { InterruptedSession } from "../protocol";
import type { Studio } from "../studio";
import { formatCount, plain } from "../words";

interface OpenAction {
  open: () => void;
  /** What is asked first; null where nothing is. */
  asks: ComponentChildren;
}

/** Opens an automaton; `left` is its lesson that was cut off, where what is saved is meant. */
export function useOpenAction(studio: Studio, name: string, left?: InterruptedSession): OpenAction {
  const panel = usePanel();
  const [question, setQuestion] = useState<"unsaved" | "cut off" | null>(null);
  const { session } = studio;
  const send = async (): Promise<void> => {
    setQuestion(null);
    const answer = await studio.ask({ do: "open", name, discard: true });
    if (answer.error === undefined) panel.open("automaton");
  };
  const proceed = (): void => (left === undefined ? void send() : setQuestion("cut off"));
  const saveFirst = async (): Promise<void> => {
    if (await studio.lessonTests.save()) proceed();
  };
  const openSaved = async (): Promise<void> => {
    const answer = await studio.ask({ do: "discard", name });
    if (answer.error === undefined) await send();
  };
  const notNow = (
    <Button class="link" onClick={() => setQuestion(null)}>
      not now
    </Button>
  );
  const asks = {
    unsaved: (
      <div class="prompt" role="alert">
        <p>{plain(session?.name ?? "")} has changes that are not in the library.</p>
        <Button class="small" onClick={() => void saveFirst()}>
          Save, then open
        </Button>
        <Button class="small" onClick={proceed}>
          Open without saving
        </Button>
        {notNow}
      </div>
    ),
    "cut off": (
      <div class="prompt" role="alert">
        <p>
          A lesson of {plain(name)} was interrupted before it was saved, with{" "}
          {formatCount(left?.examples ?? 0, "example")}.
        </p>
        <Button class="small" onClick={() => void send()}>
          Resume it
        </Button>
        <Button class="small" onClick={() => void openSaved()}>
          Discard it, and open what is saved
        </Button>
        {notNow}
      </div>
    ),
  };
  return {
    open: () => (session?.unsaved === true ? setQuestion("unsaved") : proceed()),
    asks:
      question !== null && (question === "cut off" ? left !== undefined : session !== null)
        ? asks[question]
        : null,
  };
}
