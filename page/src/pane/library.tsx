/** The tab Library: the trained behaviors of the folder; open, save as, delete with a way back. */

import { useState } from "preact/hooks";
import { ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import { Form, Input } from "../fields";
import { Behavior } from "./behavior";
import { InterruptedLesson } from "./interrupted";
import { LibraryTransfer } from "./librarytransfer";
import { Places } from "./places";
import { plain } from "../words";

export function LibraryTab() {
  const studio = useStudio();
  const panel = usePanel();
  const { status, session } = studio;
  if (status === null) return null;
  const { folder, trained, trash, basic, interrupted: cutOff } = status.library;
  return (
    <>
      {session !== null && <SaveAs name={session.name} />}
      {cutOff.length > 0 && (
        <ul>
          {cutOff.map((left) => (
            <InterruptedLesson key={left.name} left={left} />
          ))}
        </ul>
      )}
      {trained.length === 0 && cutOff.length === 0 && (
        <p class="empty">
          No behavior is saved yet. Teach one and save it: it becomes a state that other automata can use.
        </p>
      )}
      <ul>
        {trained.map((each) => (
          <Behavior key={each.name} trained={each} />
        ))}
      </ul>
      <p>
        <ControlButton onClick={() => panel.choose("new")}>+ Teach something new</ControlButton>
      </p>
      <h3>Basic behaviors</h3>
      <p class="tiny">{basic.map(plain).join(", ")}</p>
      {trash.length > 0 && (
        <>
          <h3>Deleted</h3>
          <ul class="trash">
            {trash.map((name) => (
              <li key={name}>
                {plain(name)}
                <ControlButton class="link" request={{ do: "restore", name }}>
                  bring back
                </ControlButton>
              </li>
            ))}
          </ul>
        </>
      )}
      <Places />
      <h3>As a file</h3>
      <LibraryTransfer />
      {studio.storageNote === "" && <p class="tiny folder">in the folder {folder}</p>}
    </>
  );
}

function SaveAs({ name }: { name: string }) {
  const studio = useStudio();
  const [wanted, setWanted] = useState("");
  const save = (): void => {
    if (wanted.trim() === "") return;
    void studio.ask({ do: "save", name: wanted.trim() });
    setWanted("");
  };
  return (
    <Form class="flex save-as" submit={save}>
      <label>
        Save {plain(name)} as{" "}
        <Input value={wanted} placeholder="another name" disabled={!studio.hasControl} change={setWanted} />
      </label>
      <ControlButton type="submit" class="small" disabled={wanted.trim() === ""}>
        Save as
      </ControlButton>
    </Form>
  );
}
