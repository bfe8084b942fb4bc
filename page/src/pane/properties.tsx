/** The properties in the library's file: what their tests proved, and a form to add, change or delete one. */

import { useState } from "preact/hooks";
import { ControlButton } from "../button";
import { useStudio } from "../context";
import { Progress, Sign } from "../lists";
import type { LibraryProperty } from "../protocol";
import { className, formatCount, plain } from "../words";
import { PropertyForm } from "./propertyform";

const MARKS: Readonly<Record<LibraryProperty["verdict"], readonly [string, string, string]>> = {
  "not tested": ["○", "soft", "Not tested yet"],
  holds: ["✓", "passes", "Holds"],
  fails: ["✗", "warn", "Fails"],
  undecided: ["?", "soft", "Undecided: more worlds are needed"],
};
/** The form is open for a new property. */
const NEW = "\n";

export function PropertiesPart() {
  const studio = useStudio();
  const [changing, change] = useState<string | null>(null);
  const properties = studio.status?.properties ?? null;
  if (!studio.offers.includes("runs") || properties === null) return null;
  const { rows, problem, testing, finished, total } = properties;
  return (
    <section class="card outcomes properties" aria-label="Properties of the library">
      <div class="flex wrap outcomes-head">
        <h3>Library properties</h3>
        <ControlButton
          class="link"
          aria-expanded={changing === NEW}
          disabled={problem !== ""}
          title="What a behavior must never do, or must do in time, in which worlds"
          onClick={() => change(changing === NEW ? null : NEW)}
        >
          + property
        </ControlButton>
        {rows.length > 0 && (
          <ControlButton
            class="small"
            disabled={testing !== null}
            title="Run the worlds of all of them with what is trained as it stands"
            request={{ do: "test_properties" }}
          >
            {testing === null ? "Test all" : "Testing …"}
          </ControlButton>
        )}
      </div>
      {changing === NEW && <PropertyForm name={null} fields={null} close={() => change(null)} />}
      {testing !== null && (
        <Progress label="Worlds of a property run" finished={finished} total={total}>
          {testing}: {finished} of {formatCount(total, "world")}
        </Progress>
      )}
      {problem !== "" && <p class="warn">{problem}</p>}
      {rows.length === 0 && problem === "" && changing === null && (
        <p class="tiny">What a behavior must never do, or must do in time, tested in many worlds.</p>
      )}
      <ul>
        {rows.map((row) => (
          <PropertyItem key={row.name} row={row} open={changing === row.name} change={change} />
        ))}
      </ul>
    </section>
  );
}

interface ItemProps {
  row: LibraryProperty;
  open: boolean;
  change: (name: string | null) => void;
}

function PropertyItem({ row, open, change }: ItemProps) {
  const studio = useStudio();
  const { name, claim, problem, fields, verdict, sentences, stale } = row;
  const [mark, tone, means] = problem === "" ? MARKS[verdict] : ["!", "warn", "Its table is not valid"];
  const remove = (): void => {
    const request = { do: "delete_property", name } as const;
    if (fields === null) void studio.ask(request);
    else void studio.change(request, { do: "save_property", name, fields });
  };
  return (
    <>
      <li>
        <Sign tone={tone} means={means}>
          {mark}
        </Sign>
        <span class="claim">
          {name}{" "}
          <span class="soft">
            {problem === ""
              ? `${plain(fields?.behavior ?? "")} in ${plain(fields?.world ?? "")}: ${claim}`
              : problem}
          </span>
        </span>
        {fields !== null && (
          <ControlButton
            class="link"
            aria-expanded={open}
            aria-label={`Change property ${name}`}
            onClick={() => change(open ? null : name)}
          >
            change
          </ControlButton>
        )}
        <ControlButton
          class="link"
          aria-label={`Delete property ${name}`}
          title="Delete it from the library's file (can be undone)"
          onClick={remove}
        >
          ×
        </ControlButton>
      </li>
      {sentences.map((sentence) => (
        <li key={sentence} class={className("proved", stale && "stale")}>
          {sentence}
        </li>
      ))}
      {stale && <li class="proved">tested before the lesson changed</li>}
      {open && fields !== null && (
        <li class="proved">
          <PropertyForm name={name} fields={fields} close={() => change(null)} />
        </li>
      )}
    </>
  );
}
