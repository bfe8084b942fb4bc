/** The library at a glance: basic behaviors, trained ones, and the way to a new one. */

import { Button, ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import { className, formatCount, plain } from "../words";

export function LibraryList() {
  const studio = useStudio();
  const panel = usePanel();
  const { status, session } = studio;
  if (status === null) return null;
  const { basic, trained } = status.library;
  const isSaved = trained.some(({ name }) => name === session?.name);
  return (
    <section>
      <h2>Library</h2>
      <details class="basic">
        <summary class="row">
          basic <span class="soft">{basic.length}</span>
        </summary>
        <p class="tiny list">{basic.map(plain).join(", ")}</p>
      </details>
      <ul>
        {session !== null && !isSaved && (
          <li class="row on">
            <span aria-hidden="true">◆</span>
            <b>{plain(session.name)}</b>
            <span class="soft cut">not saved yet</span>
          </li>
        )}
        {trained.map(({ name, parameters, runs, examples, complete }) => (
          <li key={name}>
            <Button
              class={className("row", name === session?.name && "on")}
              onClick={() => panel.showBehavior(name)}
              title={complete ? "Go to it in the tab Library" : "Some choices are missing"}
            >
              <span aria-hidden="true">{name === session?.name ? "◆" : "◇"}</span>
              <b>{plain(name)}</b>
              <span class="soft cut">
                {[
                  parameters.join(", "),
                  runs.length > 0 ? runs.map(plain).join(", ") : formatCount(examples, "example"),
                ]
                  .filter(Boolean)
                  .join(" · ")}
              </span>
              {!complete && (
                <span class="warn" aria-label="not complete">
                  !
                </span>
              )}
            </Button>
          </li>
        ))}
        <li>
          <ControlButton class="row soft library-new" onClick={() => panel.choose("new")}>
            + Teach something new
          </ControlButton>
        </li>
      </ul>
    </section>
  );
}
