/** One trained behavior of the library: open it, delete it, export it, and why it is not complete. */

import { useEffect, useRef, useState } from "preact/hooks";
import { usePanel } from "../context";
import type { Trained } from "../protocol";
import type { Studio } from "../studio";
import { className, counted, plain } from "../words";
import { Exporting } from "./exporting";
import { Naming, type Way } from "./naming";
import { useOpening } from "./opening";
import { Versions } from "./versions";

type Shown = Way | "versions" | "export";

export function Behavior({ trained, studio }: { trained: Trained; studio: Studio }) {
  const panel = usePanel();
  const [shown, setShown] = useState<Shown | null>(null);
  const show = (which: Shown): void => setShown(shown === which ? null : which);
  const { name, parameters, runs, examples, versions, complete, why_not: whyNot } = trained;
  const { desk, directs } = studio;
  const here = desk?.name === name;
  const left = studio.told?.library.cut_off.find((each) => each.name === name);
  const { open, asks } = useOpening(studio, name, left);
  const place = useRef<HTMLLIElement>(null);
  const wanted = panel.behavior?.name === name;
  useEffect(() => {
    if (!wanted) return;
    place.current?.scrollIntoView({ block: "nearest" });
    place.current?.focus({ preventScroll: true });
  }, [wanted && panel.behavior]);
  return (
    <li
      ref={place}
      class={className("behavior", here && "on", wanted && "wanted")}
      tabIndex={-1}
      aria-current={wanted ? "true" : undefined}
    >
      <div class="behavior-head">
        <b>
          {plain(name)}
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
              onClick={open}
            >
              Open
            </button>
            <button
              type="button"
              class="small danger"
              aria-label={`Delete ${name}`}
              disabled={!directs}
              onClick={() => void studio.change({ do: "remove", name }, { do: "restore", name })}
            >
              Delete
            </button>
          </>
        )}
      </div>
      <p class="tiny">
        {counted(examples, "example")}
        {runs.length > 0 && `, runs ${runs.map(plain).join(", ")}`}
      </p>
      <p class="behavior-more">
        {(["rename", "duplicate"] as const).map((way) => (
          <button
            type="button"
            key={way}
            class="link"
            aria-label={`${way === "rename" ? "Rename" : "Duplicate"} ${name}`}
            aria-expanded={shown === way}
            disabled={!directs}
            onClick={() => show(way)}
          >
            {way}
          </button>
        ))}
        <button
          type="button"
          class="link"
          aria-label={`Versions of ${name}`}
          aria-expanded={shown === "versions"}
          onClick={() => show("versions")}
        >
          {versions === 0 ? "versions" : counted(versions, "former version")}
        </button>
        <button
          type="button"
          class="link"
          aria-label={`Export ${name}`}
          aria-expanded={shown === "export"}
          disabled={!complete}
          onClick={() => show("export")}
        >
          export
        </button>
      </p>
      {(shown === "rename" || shown === "duplicate") && (
        <Naming key={shown} way={shown} name={name} studio={studio} close={() => setShown(null)} />
      )}
      {shown === "export" && complete && <Exporting trained={trained} studio={studio} />}
      {shown === "versions" && <Versions name={name} count={versions} studio={studio} />}
      {!complete && <p class="warn">Not complete: {plain(whyNot ?? "something it needs is missing")}</p>}
      {asks}
    </li>
  );
}
