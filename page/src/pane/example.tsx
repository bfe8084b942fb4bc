/** An example that is selected: its states and values can be changed, it can be deleted, and gone back to. */

import { useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { useStudio } from "../context";
import { Select } from "../fields";
import type { Example, Feature, Session } from "../protocol";
import { formatTime, plain } from "../words";
import type { TableProps } from "./examples";

type Part = { state: string } | { next: string } | { values: Readonly<Record<string, string>> };

export function Detail({ example, session, panel }: TableProps & { example: Example }) {
  const studio = useStudio();
  const [confirms, setConfirms] = useState(false);
  const { number, state, next } = example;
  const remove = async (): Promise<void> => {
    const answer = await studio.change({ do: "delete", number }, { do: "undo" });
    if (answer.error === undefined) panel.selectExample(null);
  };
  const edit = async (part: Part): Promise<boolean> => {
    const request = { do: "edit", number, state: null, next: null, values: {}, ...part } as const;
    return (await studio.change(request, { do: "undo" })).error === undefined;
  };
  return (
    <div class="flex wrap detail-row">
      <label>
        in{" "}
        <StateSelect
          value={state}
          names={session.states.flatMap((each) => (each.flag ? [] : [each.name]))}
          change={(name) => void edit({ state: name })}
        />
      </label>
      <label>
        go to{" "}
        <StateSelect
          value={next}
          names={session.states.map(({ name }) => name)}
          stay={state}
          change={(name) => void edit({ next: name })}
        />
      </label>
      <ControlButton
        class="small"
        title="Go back to just before it was shown"
        request={{ do: "rewind", example: number }}
      >
        Go there
      </ControlButton>
      <ControlButton class="small danger" onClick={() => void remove()}>
        Delete
      </ControlButton>
      <ControlButton
        class="small"
        title={example.quarantined === "" ? "Ignore this example when learning" : example.quarantined}
        onClick={() =>
          void studio.ask({ do: example.quarantined === "" ? "quarantine" : "release", numbers: [number] })
        }
      >
        {example.quarantined === "" ? "Ignore" : "Use it again"}
      </ControlButton>
      {session.features.length > 0 && (
        <Button class="link" aria-expanded={confirms} onClick={() => setConfirms(!confirms)}>
          values
        </Button>
      )}
      {example.source !== "" ? (
        <span class="tiny">from {example.source}</span>
      ) : (
        example.time_s !== null && <span class="tiny">shown at {formatTime(example.time_s)}</span>
      )}
      {confirms && <Values example={example} session={session} edit={edit} />}
      {example.quarantined !== "" && <p class="tiny warn">In quarantine. {example.quarantined}</p>}
      {example.contradicts && (
        <p class="tiny warn">Contradicts another example: same readings, different press.</p>
      )}
    </div>
  );
}

interface StateSelectProps {
  value: string;
  names: readonly string[];
  /** The state that is no change. */
  stay?: string;
  change: (name: string) => void;
}

function StateSelect({ value, names, stay, change }: StateSelectProps) {
  const studio = useStudio();
  return (
    <Select
      value={value}
      among={names.map((name) => [name, name === stay ? `${plain(name)} (stay)` : plain(name)])}
      disabled={!studio.hasControl}
      change={(name, select) => {
        select.value = value; // until the server says so
        change(name);
      }}
    />
  );
}

interface ValuesProps {
  example: Example;
  session: Session;
  edit: (part: Part) => Promise<boolean>;
}

function Values({ example, session, edit }: ValuesProps) {
  const studio = useStudio();
  const change = async (feature: Feature, field: HTMLInputElement | HTMLSelectElement, text: string) => {
    const done = field.value === text || (await edit({ values: { [feature.label]: field.value } }));
    if (!done) field.value = text;
  };
  return (
    <div class="values">
      {session.features.map((feature, index) => {
        const text = example.values[index] ?? "";
        const options = {
          value: text,
          disabled: !studio.hasControl,
          onChange: (event: { currentTarget: HTMLInputElement | HTMLSelectElement }) =>
            void change(feature, event.currentTarget, text),
        };
        return (
          <label key={feature.label}>
            {plain(feature.label)}{" "}
            {feature.labels === undefined ? (
              <input {...options} autocomplete="off" />
            ) : (
              <select {...options}>
                {[...feature.labels, "–"].map((label) => (
                  <option key={label} value={label}>
                    {label === "–" ? "– (absent)" : label}
                  </option>
                ))}
              </select>
            )}
          </label>
        );
      })}
    </div>
  );
}
