/** Where one teaches: other worlds and libraries, and the world as it stands as one more. */

import { useState } from "preact/hooks";
import { Prompt } from "../confirm";
import { useStudio } from "../context";
import { ControlSelect, Field, Form, Input } from "../fields";
import type { Request } from "../protocol";
import type { Studio } from "../studio";
import { plain } from "../words";

/** What is chosen for a library that does not exist yet. */
const NEW = "\n";

type PlaceRequest = Extract<Request, { do: "open_world" | "open_library" }>;

/** Goes somewhere else; changes that are not saved are asked about first. */
export function usePlaceChange(studio: Studio) {
  const [destination, setDestination] = useState<PlaceRequest | null>(null);
  const send = async (to: PlaceRequest): Promise<void> => {
    setDestination(null);
    await studio.ask({ ...to, discard: true });
  };
  const saveFirst = async (to: PlaceRequest): Promise<void> => {
    if (await studio.lessonTests.save()) await send(to);
  };
  const go = (to: PlaceRequest): void => {
    if (studio.session?.unsaved === true) setDestination(to);
    else void send(to);
  };
  const asks = destination !== null && studio.session !== null && (
    <Prompt
      answers={{
        [`Save, then go to ${destination.name}`]: () => void saveFirst(destination),
        "Go without saving": () => void send(destination),
      }}
      onClose={() => setDestination(null)}
    >
      {plain(studio.session.name)} has changes that are not in the library.
    </Prompt>
  );
  return { go, asks };
}

export function Places() {
  const studio = useStudio();
  const { go, asks } = usePlaceChange(studio);
  if (studio.status === null || !studio.status.places.can_save) return null;
  return (
    <>
      <h3>World</h3>
      <WorldChoice go={go} />
      <SaveWorld />
      <h3>Library</h3>
      <LibraryChoice go={go} />
      {asks}
    </>
  );
}

interface ChoiceProps {
  go: (to: PlaceRequest) => void;
}

function WorldChoice({ go }: ChoiceProps) {
  const studio = useStudio();
  if (studio.status === null) return null;
  const { world, worlds } = studio.status.places;
  return (
    <Field label="Teach in">
      <ControlSelect
        value={world}
        among={worlds}
        aria-label="World"
        change={(name) => go({ do: "open_world", name, discard: false })}
      />
    </Field>
  );
}

function SaveWorld() {
  const studio = useStudio();
  const [name, setName] = useState("");
  const wanted = name.trim();
  const save = async (): Promise<void> => {
    const { error } = await studio.ask({ do: "save_world", name: wanted });
    if (error === undefined) setName("");
  };
  return (
    <NameForm
      label="Save it as"
      hint="my-world"
      about="Everything as it stands now, as a scenario file."
      button="Save world"
      name={name}
      change={setName}
      enabled={studio.hasControl && wanted !== ""}
      act={save}
    />
  );
}

function LibraryChoice({ go }: ChoiceProps) {
  const studio = useStudio();
  const [making, setMaking] = useState(false);
  const [name, setName] = useState("");
  if (studio.status === null) return null;
  const { library, libraries } = studio.status.places;
  const make = async (): Promise<void> => {
    go({ do: "open_library", name: name.trim(), discard: false });
    setMaking(false);
    setName("");
  };
  return (
    <>
      <Field label="Folder">
        <ControlSelect
          value={making ? NEW : library}
          among={[...libraries.map((each) => [each, each] as const), [NEW, "new library …"]]}
          aria-label="Library"
          change={(chosen) => {
            setMaking(chosen === NEW);
            if (chosen !== NEW) go({ do: "open_library", name: chosen, discard: false });
          }}
        />
      </Field>
      {making && (
        <NameForm
          label="New library"
          hint="my library"
          about="A folder beside the others, made when something is saved in it."
          button="Begin it"
          name={name}
          change={setName}
          enabled={studio.hasControl && name.trim() !== ""}
          act={make}
        />
      )}
    </>
  );
}

interface NameFormProps {
  label: string;
  hint: string;
  about: string;
  button: string;
  name: string;
  change: (name: string) => void;
  enabled: boolean;
  act: () => Promise<void>;
}

function NameForm({ label, hint, about, button, name, change, enabled, act }: NameFormProps) {
  return (
    <Form class="place-name" submit={() => void (enabled && act())}>
      <Field label={label} about={about}>
        <Input value={name} placeholder={hint} maxLength={150} change={change} />
      </Field>
      <button type="submit" class="small" disabled={!enabled}>
        {button}
      </button>
    </Form>
  );
}
