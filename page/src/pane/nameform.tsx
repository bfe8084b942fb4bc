/** Another name for a trained behavior: for itself, or for a copy of it. */

import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { useStudio } from "../context";
import { Form, Input } from "../fields";
import { listenTo } from "../listen";

export type Way = "rename" | "duplicate";

interface Props {
  way: Way;
  name: string;
  close: () => void;
}

export function NameForm({ way, name, close }: Props) {
  const studio = useStudio();
  const [to, setTo] = useState(way === "rename" ? name : `${name} 2`);
  const field = useRef<HTMLInputElement>(null);
  useLayoutEffect(() => {
    field.current?.focus(); // selecting alone leaves Escape and letters to the page
    field.current?.select();
  }, []);
  useLayoutEffect(() => {
    // As soon as the field is there: an effect after the next frame would miss an Escape pressed before it.
    return listenTo(globalThis, {
      keydown: ({ key }) => key === "Escape" && close(), // even if another element has the focus by then
    });
  });
  const wanted = to.trim();
  const useless = wanted === "" || wanted === name || !studio.hasControl;
  const act = async (): Promise<void> => {
    const answer = await studio.ask({ do: way, name, to: wanted });
    if (answer.error === undefined) close();
  };
  return (
    <Form class="name-form" submit={() => void (useless || act())}>
      <Input
        ref={field}
        value={to}
        maxLength={150}
        aria-label={way === "rename" ? `New name of ${name}` : `Name of the copy of ${name}`}
        change={setTo}
      />
      <button type="submit" class="small" disabled={useless}>
        {way === "rename" ? "Rename" : "Duplicate"}
      </button>
    </Form>
  );
}
