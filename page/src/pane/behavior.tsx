/** One trained behavior of the library: open it, delete it, export it, and why it is not complete. */

import { useEffect, useRef, useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { usePanel, useStudio } from "../context";
import type { TrainedBehavior } from "../protocol";
import { className, formatCount, plain } from "../words";
import { ExportForm } from "./exportform";
import { NameForm, type Way } from "./nameform";
import { useOpenAction } from "./openaction";
import { Versions } from "./versions";

type BehaviorPart = Way | "versions" | "export";

export function Behavior({ trained }: { trained: TrainedBehavior }) {
  const studio = useStudio();
  const panel = usePanel();
  const [openPart, setOpenPart] = useState<BehaviorPart | null>(null);
  const show = (which: BehaviorPart): void => setOpenPart(openPart === which ? null : which);
  const { name, parameters, runs, examples, versions, complete, problem: whyNot } = trained;
  const { session } = studio;
  const here = session?.name === name;
  const left = studio.status?.library.interrupted.find((each) => each.name === name);
  const { open, asks } = useOpenAction(studio, name, left);
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
      class={className("card", "behavior", here && "on", wanted && "wanted")}
      tabIndex={-1}
      aria-current={wanted ? "true" : undefined}
    >
      <div class="flex behavior-head">
        <b>
          {plain(name)}
          {parameters.length > 0 && <span class="soft"> ({parameters.join(", ")})</span>}
        </b>
        <span class="space" />
        {here ? (
          <span class="tiny">being trained</span>
        ) : (
          <>
            <ControlButton class="small" aria-label={`Open ${name}`} onClick={open}>
              Open
            </ControlButton>
            <ControlButton
              class="small danger"
              aria-label={`Delete ${name}`}
              request={{ do: "remove", name }}
              back={{ do: "restore", name }}
            >
              Delete
            </ControlButton>
          </>
        )}
      </div>
      <p class="tiny">
        {formatCount(examples, "example")}
        {runs.length > 0 && `, runs ${runs.map(plain).join(", ")}`}
      </p>
      <p class="more">
        {(["rename", "duplicate"] as const).map((way) => (
          <ControlButton
            key={way}
            class="link"
            aria-label={`${way === "rename" ? "Rename" : "Duplicate"} ${name}`}
            aria-expanded={openPart === way}
            onClick={() => show(way)}
          >
            {way}
          </ControlButton>
        ))}
        <Button
          class="link"
          aria-label={`Versions of ${name}`}
          aria-expanded={openPart === "versions"}
          onClick={() => show("versions")}
        >
          {versions === 0 ? "versions" : formatCount(versions, "former version")}
        </Button>
        <Button
          class="link"
          aria-label={`Export ${name}`}
          aria-expanded={openPart === "export"}
          disabled={!complete}
          onClick={() => show("export")}
        >
          export
        </Button>
      </p>
      {(openPart === "rename" || openPart === "duplicate") && (
        <NameForm key={openPart} way={openPart} name={name} close={() => setOpenPart(null)} />
      )}
      {openPart === "export" && complete && <ExportForm trained={trained} />}
      {openPart === "versions" && <Versions name={name} count={versions} />}
      {!complete && <p class="warn">Not complete: {plain(whyNot ?? "something it needs is missing")}</p>}
      {asks}
    </li>
  );
}
