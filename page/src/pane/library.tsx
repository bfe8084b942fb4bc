/** The tab Library: the trained behaviors of the folder; open, save as, delete with a way back. */

import { useState } from "preact/hooks";
import { usePanel, useStudio } from "../context";
import type { Trained } from "../protocol";
import type { Studio } from "../studio";
import { className, counted } from "../words";

export function LibraryTab() {
  const studio = useStudio();
  const panel = usePanel();
  const { told, desk, directs } = studio;
  if (told === null) return null;
  const { folder, trained, trash, basic, cut_off: cutOff } = told.library;
  return (
    <>
      {desk !== null && <SaveAs studio={studio} name={desk.name} />}
      {cutOff.length > 0 && (
        <ul class="behaviors">
          {cutOff.map(({ name, examples }) => (
            <li class="behavior" key={name}>
              <div class="behavior-head">
                <b>{name}</b>
                <span class="space" />
                <button
                  type="button"
                  class="small"
                  disabled={!directs}
                  onClick={() => void studio.ask({ do: "open", name })}
                >
                  Go on
                </button>
              </div>
              <p class="tiny">cut off before it was saved, with {counted(examples, "example")}</p>
            </li>
          ))}
        </ul>
      )}
      {trained.length === 0 && cutOff.length === 0 && (
        <p class="empty">
          No behavior is saved yet. Teach one and save it: it becomes a state that other automata can use.
        </p>
      )}
      <ul class="behaviors">
        {trained.map((each) => (
          <Behavior key={each.name} trained={each} studio={studio} />
        ))}
      </ul>
      <p class="padded">
        <button type="button" disabled={!directs} onClick={() => panel.choose("new")}>
          + new automaton
        </button>
      </p>
      <h3>Basic behaviors</h3>
      <p class="padded tiny">{basic.join(", ")}</p>
      {trash.length > 0 && (
        <>
          <h3>Deleted</h3>
          <ul class="trash">
            {trash.map((name) => (
              <li key={name}>
                {name}
                <button
                  type="button"
                  class="link"
                  disabled={!directs}
                  onClick={() => void studio.ask({ do: "restore", name })}
                >
                  bring back
                </button>
              </li>
            ))}
          </ul>
        </>
      )}
      <p class="padded tiny folder">in the folder {folder}</p>
    </>
  );
}

function Behavior({ trained, studio }: { trained: Trained; studio: Studio }) {
  const panel = usePanel();
  const [asks, setAsks] = useState(false);
  const { name, parameters, runs, examples, complete, why_not: whyNot } = trained;
  const { desk, directs } = studio;
  const here = desk?.name === name;
  const open = async (discard: boolean): Promise<void> => {
    if (desk !== null && desk.unsaved && !discard) return setAsks(true);
    setAsks(false);
    const answer = await studio.ask({ do: "open", name, discard });
    if (answer.error === undefined) panel.open("automaton");
  };
  const saveFirst = async (): Promise<void> => {
    const answer = await studio.ask({ do: "save", name: null });
    if (answer.error === undefined) await open(true);
  };
  const remove = async (): Promise<void> => {
    const answer = await studio.ask({ do: "remove", name });
    if (answer.error !== undefined) return;
    studio.say({ text: `${name} is deleted.`, tone: "recorded", undo: { do: "restore", name } });
  };
  return (
    <li class={className("behavior", here && "on")}>
      <div class="behavior-head">
        <b>
          {name}
          {parameters.length > 0 && <span class="soft"> ({parameters.join(", ")})</span>}
        </b>
        <span class="space" />
        {here ? (
          <span class="tiny">being trained</span>
        ) : (
          <>
            <button
              type="button"
              class="small"
              aria-label={`Open ${name}`}
              disabled={!directs}
              onClick={() => void open(false)}
            >
              Open
            </button>
            <button
              type="button"
              class="small danger"
              aria-label={`Delete ${name}`}
              disabled={!directs}
              onClick={() => void remove()}
            >
              Delete
            </button>
          </>
        )}
      </div>
      <p class="tiny">
        {counted(examples, "example")}
        {runs.length > 0 && `, runs ${runs.join(", ")}`}
      </p>
      {!complete && <p class="warn">Not complete: {whyNot ?? "something it needs is missing"}</p>}
      {asks && desk !== null && (
        <div class="asks" role="alert">
          <p>{desk.name} has changes that are not in the library.</p>
          <button type="button" class="small" onClick={() => void saveFirst()}>
            Save, then open
          </button>
          <button type="button" class="small" onClick={() => void open(true)}>
            Open without saving
          </button>
          <button type="button" class="link" onClick={() => setAsks(false)}>
            not now
          </button>
        </div>
      )}
    </li>
  );
}

function SaveAs({ studio, name }: { studio: Studio; name: string }) {
  const [wanted, setWanted] = useState("");
  return (
    <form
      class="save-as"
      onSubmit={(event) => {
        event.preventDefault();
        if (wanted.trim() === "") return;
        void studio.ask({ do: "save", name: wanted.trim() });
        setWanted("");
      }}
    >
      <label>
        Save {name} as{" "}
        <input
          value={wanted}
          placeholder="another name"
          disabled={!studio.directs}
          onInput={(event) => setWanted(event.currentTarget.value)}
        />
      </label>
      <button type="submit" class="small" disabled={!studio.directs || wanted.trim() === ""}>
        Save as
      </button>
    </form>
  );
}
