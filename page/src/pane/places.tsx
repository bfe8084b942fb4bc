/** Where one teaches: other worlds and libraries, and the world as it stands as one more. */

import { useState } from "preact/hooks";
import { Button } from "../button";
import { useStudio } from "../context";
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
    <div class="prompt" role="alert">
      <p>{plain(studio.session.name)} has changes that are not in the library.</p>
      <Button class="small" onClick={() => void saveFirst(destination)}>
        Save, then go to {destination.name}
      </Button>
      <Button class="small" onClick={() => void send(destination)}>
        Go without saving
      </Button>
      <Button class="link" onClick={() => setDestination(null)}>
        not now
      </Button>
    </div>
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
      <WorldChoice studio={studio} go={go} />
      <SaveWorld studio={studio} />
      <h3>Library</h3>
      <LibraryChoice studio={studio} go={go} />
      {asks}
    </>
  );
}

interface ChoiceProps {
  studio: Studio;
  go: (to: PlaceRequest) => void;
}

function WorldChoice({ studio, go }: ChoiceProps) {
  if (studio.status === null) return null;
  const { world, worlds } = studio.status.places;
  return (
    <label class="field">
      <span>Teach in</span>
      <select
        value={world}
        aria-label="World"
        disabled={!studio.hasControl}
        onChange={(event) => {
          const name = event.currentTarget.value;
          event.currentTarget.value = world; // until the server says so
          event.currentTarget.blur();
          go({ do: "open_world", name, discard: false });
        }}
      >
        {worlds.map((each) => (
          <option key={each} value={each}>
            {plain(each)}
          </option>
        ))}
      </select>
    </label>
  );
}

function SaveWorld({ studio }: { studio: Studio }) {
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

function LibraryChoice({ studio, go }: ChoiceProps) {
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
      <label class="field">
        <span>Folder</span>
        <select
          value={making ? NEW : library}
          aria-label="Library"
          disabled={!studio.hasControl}
          onChange={(event) => {
            const chosen = event.currentTarget.value;
            setMaking(chosen === NEW);
            if (chosen !== NEW) {
              event.currentTarget.value = library;
              go({ do: "open_library", name: chosen, discard: false });
            }
            event.currentTarget.blur();
          }}
        >
          {libraries.map((each) => (
            <option key={each} value={each}>
              {each}
            </option>
          ))}
          <option value={NEW}>new library …</option>
        </select>
      </label>
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
    <form
      class="place-name"
      onSubmit={(event) => {
        event.preventDefault();
        if (enabled) void act();
      }}
    >
      <label class="field">
        <span>{label}</span>
        <input
          value={name}
          placeholder={hint}
          maxLength={150}
          spellcheck={false}
          autocomplete="off"
          onInput={(event) => change(event.currentTarget.value)}
        />
        <span class="tiny">{about}</span>
      </label>
      <button type="submit" class="small" disabled={!enabled}>
        {button}
      </button>
    </form>
  );
}
