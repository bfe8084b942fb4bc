/** Former versions of a trained behavior: what changed after each, and going back to one. */

import { useEffect, useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { useStudio } from "../context";
import type { Version } from "../protocol";
import { formatMoment } from "../words";
import { Changes } from "./changes";

export function Versions({ name, count }: { name: string; count: number }) {
  const studio = useStudio();
  const [versions, setVersions] = useState<readonly Version[] | null>(null);
  const [picked, setPicked] = useState<number | null>(null);
  useEffect(() => {
    void studio.ask({ do: "list_versions", name }).then((answer) => setVersions(answer.versions ?? []));
  }, [name, count]);
  if (versions === null) return null;
  if (versions.length === 0) {
    return <p class="tiny">No former version: one is kept whenever it is saved anew.</p>;
  }
  return (
    <ul class="versions" aria-label={`Versions of ${name}`}>
      {versions.map(({ number, saved }) => (
        <li key={number}>
          <div class="flex behavior-head">
            <Button
              class="link"
              aria-expanded={picked === number}
              onClick={() => setPicked(picked === number ? null : number)}
            >
              version {number}
            </Button>
            <span class="tiny">{formatMoment(saved)}</span>
            <span class="space" />
            <ControlButton
              class="small"
              aria-label={`Go back to version ${number} of ${name}`}
              request={{ do: "go_back", name, version: number }}
            >
              Go back to it
            </ControlButton>
          </div>
          {picked === number && <Changes name={name} version={number} count={count} versions={versions} />}
        </li>
      ))}
    </ul>
  );
}
