/** Opening an automaton: what would be left behind is asked in place, never over the running world. */

import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { Prompt } from "../confirm";
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
  const close = (): void => setQuestion(null);
  const asks = {
    unsaved: (
      <Prompt
        answers={{ "Save, then open": () => void saveFirst(), "Open without saving": proceed }}
        onClose={close}
      >
        {plain(session?.name ?? "")} has changes that are not in the library.
      </Prompt>
    ),
    "cut off": (
      <Prompt
        answers={{
          "Resume it": () => void send(),
          "Discard it, and open what is saved": () => void openSaved(),
        }}
        onClose={close}
      >
        A lesson of {plain(name)} was interrupted before it was saved, with{" "}
        {formatCount(left?.examples ?? 0, "example")}.
      </Prompt>
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
