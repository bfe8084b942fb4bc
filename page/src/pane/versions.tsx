/** Former versions of a trained behavior: what changed after each, and going back to one. */

import { useEffect, useState } from "preact/hooks";
import type { Change, Version } from "../protocol";
import type { Studio } from "../studio";
import { className, counted, minus, when } from "../words";

export function Versions({ name, count, studio }: { name: string; count: number; studio: Studio }) {
  const [versions, setVersions] = useState<readonly Version[] | null>(null);
  const [picked, setPicked] = useState<number | null>(null);
  useEffect(() => {
    void studio.ask({ do: "versions", name }).then((answer) => setVersions(answer.versions ?? []));
  }, [name, count]);
  if (versions === null) return null;
  if (versions.length === 0) {
    return <p class="tiny">No former version: one is kept whenever it is saved anew.</p>;
  }
  return (
    <ul class="versions" aria-label={`Versions of ${name}`}>
      {versions.map(({ number, saved }) => (
        <li key={number}>
          <div class="behavior-head">
            <button
              type="button"
              class="link"
              aria-expanded={picked === number}
              onClick={() => setPicked(picked === number ? null : number)}
            >
              version {number}
            </button>
            <span class="tiny">{when(saved)}</span>
            <span class="space" />
            <button
              type="button"
              class="small"
              aria-label={`Go back to version ${number} of ${name}`}
              disabled={!studio.directs}
              onClick={() => void studio.ask({ do: "go_back", name, version: number })}
            >
              Go back to it
            </button>
          </div>
          {picked === number && (
            <Changes
              name={name}
              version={number}
              count={count}
              last={number === versions[0]?.number}
              studio={studio}
            />
          )}
        </li>
      ))}
    </ul>
  );
}

interface ChangesProps {
  name: string;
  version: number;
  count: number;
  last: boolean;
  studio: Studio;
}

function Changes({ name, version, count: former, last, studio }: ChangesProps) {
  const [next, setNext] = useState(false);
  const [changes, setChanges] = useState<readonly Change[] | null>(null);
  useEffect(() => {
    const asked = studio.ask({ do: "changes", name, version, next });
    void asked.then((answer) => setChanges(answer.changes ?? null));
  }, [name, version, next, former]);
  if (changes === null) return null;
  const count = changes.flatMap(({ lines }) => lines).filter((line) => /^[+-]/.test(line)).length;
  return (
    <div class="changes" role="region" aria-label={`What changed since version ${version}`}>
      <p class="tiny">
        {count === 0 ? "Nothing changed" : counted(count, "change")} {next ? "up to the next" : "since"}.{" "}
        {!last && (
          <button type="button" class="link" onClick={() => setNext(!next)}>
            {next ? "all since" : "only up to the next version"}
          </button>
        )}
      </p>
      {changes.map(({ topic, lines }) => (
        <div key={topic}>
          <h4>{topic}</h4>
          {lines.map((line, index) => (
            <p key={index} class={className("change", /^\+/.test(line) && "new", /^-/.test(line) && "gone")}>
              {line.startsWith("-") ? minus(line) : line.trim()}
            </p>
          ))}
        </div>
      ))}
    </div>
  );
}
