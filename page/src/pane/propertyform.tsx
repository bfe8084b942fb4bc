/** The form of a property: the keys of its table in the file, with choices from its world and its behavior. */

import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";
import { Button, ControlButton } from "../button";
import { useStudio } from "../context";
import { Field, Form, Input, Select } from "../fields";
import type { PropertyChoicesReply, PropertyFields, PropertyKind } from "../protocol";
import type { Studio } from "../studio";

const KINDS: Readonly<Record<PropertyKind, readonly [kind: string, condition: string]>> = {
  never: ["never", "Never"],
  always: ["always within a time", "Reached"],
  "never longer": ["never for longer than a time", "Not for long"],
  progress: ["never longer without progress", ""],
};
/** The fields of the form that have a mistake of their own shown beside them. */
type Mistake = { field: string; mistake: string };
/** What a property is about at first. */
const SEEDS = "200";
const TIMES: Readonly<Record<PropertyKind, number | null>> = {
  never: null,
  always: 60,
  "never longer": 60,
  progress: 120,
};

interface FormProps {
  /** The property that is changed; null for a new one. */
  name: string | null;
  fields: PropertyFields | null;
  close: () => void;
}

function begin(studio: Studio): PropertyFields {
  const behavior = studio.session?.name ?? studio.status?.library.trained[0]?.name ?? "";
  const world = studio.status?.places.world ?? "";
  return {
    kind: "never",
    condition: "",
    seconds: null,
    behavior,
    targets: {},
    world,
    seeds: SEEDS,
    limit_s: null,
    at_least: null,
  };
}

/** What can be named, asked again when the world or the behavior changes. */
function useChoices(studio: Studio, world: string, behavior: string): PropertyChoicesReply | null {
  const [choices, setChoices] = useState<PropertyChoicesReply | null>(null);
  useEffect(() => {
    let over = false;
    const ask = async (): Promise<void> => {
      const { worlds, behaviors, bindable, conditions } = await studio.ask({
        do: "property_choices",
        world,
        behavior,
      });
      if (over || worlds === undefined) return;
      setChoices({
        worlds,
        behaviors: behaviors ?? [],
        bindable: bindable ?? [],
        conditions: conditions ?? [],
      });
    };
    void ask();
    return () => {
      over = true;
    };
  }, [world, behavior]);
  return choices;
}

export function PropertyForm({ name, fields, close }: FormProps) {
  const studio = useStudio();
  const [called, call] = useState(name ?? "");
  const [draft, setDraft] = useState(() => fields ?? begin(studio));
  const [mistake, setMistake] = useState<Mistake | null>(null);
  const [saving, setSaving] = useState(false);
  const choices = useChoices(studio, draft.world, draft.behavior);
  const set = (changed: Partial<PropertyFields>): void => setDraft({ ...draft, ...changed });
  const parameters = choices?.behaviors.find((each) => each.name === draft.behavior)?.parameters ?? [];
  const bindable = choices?.bindable ?? [];
  const targets = Object.fromEntries(
    parameters.map((each) => [each, draft.targets[each] ?? bindable[0] ?? ""]),
  );
  const save = async (): Promise<void> => {
    setSaving(true);
    const answer = await studio.ask({
      do: "save_property",
      name: called.trim(),
      fields: { ...draft, targets: choices === null ? draft.targets : targets },
      changes: name !== null,
    });
    setSaving(false);
    if (answer.mistake !== undefined) setMistake({ field: answer.field ?? "", mistake: answer.mistake });
    else if (answer.error === undefined) close();
  };
  const mistakeOf = (field: string) => (mistake?.field === field ? mistake.mistake : null);
  return (
    <Form
      class="property-form"
      aria-label={name === null ? "New property" : `Property ${name}`}
      submit={() => void save()}
    >
      {name === null && (
        <PropertyField label="Name" mistake={mistakeOf("name")}>
          <Input value={called} placeholder="clear-of-the-station" maxLength={150} change={call} />
        </PropertyField>
      )}
      <PropertyField label="Behavior" mistake={mistakeOf("behavior")}>
        <Choice
          value={draft.behavior}
          among={choices?.behaviors.map((each) => each.name) ?? []}
          choose={(behavior) => set({ behavior })}
        />
      </PropertyField>
      {parameters.map((each) => (
        <PropertyField key={each} label={`Target ${each}`} mistake={mistakeOf("targets")}>
          <Choice
            value={targets[each] ?? ""}
            among={bindable}
            choose={(target) => set({ targets: { ...targets, [each]: target } })}
          />
        </PropertyField>
      ))}
      <PropertyField label="World" mistake={mistakeOf("world")}>
        <Choice value={draft.world} among={choices?.worlds ?? []} choose={(world) => set({ world })} />
      </PropertyField>
      <PropertyField label="Claim" mistake={mistakeOf("kind")}>
        <Select
          value={draft.kind}
          among={Object.entries(KINDS).map(([kind, [name]]) => [kind, name])}
          change={(chosen) => {
            const kind = chosen as PropertyKind;
            const seconds = TIMES[kind] === null ? null : (draft.seconds ?? TIMES[kind]);
            set({ kind, seconds, limit_s: kind === "always" ? null : draft.limit_s });
          }}
        />
      </PropertyField>
      {draft.kind !== "never" && (
        <PropertyField label="Time, s" mistake={mistakeOf("seconds")}>
          <NumberInput value={draft.seconds} change={(seconds) => set({ seconds })} />
        </PropertyField>
      )}
      {draft.kind !== "progress" && (
        <ConditionField
          label={KINDS[draft.kind][1]}
          draft={draft}
          choices={choices}
          mistake={mistakeOf("condition")}
          change={(condition) => set({ condition })}
        />
      )}
      <PropertyField
        label="Seeds"
        hint="A number of worlds, [1, 4], or { first = 1000, count = 500 }"
        mistake={mistakeOf("seeds")}
      >
        <Input value={draft.seeds} change={(seeds) => set({ seeds })} />
      </PropertyField>
      {draft.kind !== "always" && (
        <PropertyField
          label="Limit, s"
          hint="Of each world; that of the world if empty"
          mistake={mistakeOf("limit_s")}
        >
          <NumberInput value={draft.limit_s} change={(limit_s) => set({ limit_s })} />
        </PropertyField>
      )}
      <PropertyField
        label="At least"
        hint="A share of the worlds, such as 0.95; all if empty"
        mistake={mistakeOf("at_least")}
      >
        <NumberInput value={draft.at_least} change={(at_least) => set({ at_least })} />
      </PropertyField>
      <MistakeLine mistake={mistakeOf("")} />
      <p class="choices">
        <ControlButton type="submit" class="small primary" disabled={saving || called.trim() === ""}>
          {saving ? "Saving …" : "Save and test"}
        </ControlButton>
        <Button class="small" onClick={close}>
          Cancel
        </Button>
      </p>
    </Form>
  );
}

interface FieldProps {
  label: string;
  hint?: string;
  mistake: string | null;
  children: ComponentChildren;
}

function PropertyField({ label, hint, mistake, children }: FieldProps) {
  return (
    <>
      <Field label={label}>{children}</Field>
      {hint !== undefined && <p class="tiny">{hint}</p>}
      <MistakeLine mistake={mistake} />
    </>
  );
}

function MistakeLine({ mistake }: { mistake: string | null }) {
  if (mistake === null) return null;
  return (
    <p class="warn" role="alert">
      {mistake}
    </p>
  );
}

interface ConditionProps {
  label: string;
  draft: PropertyFields;
  choices: PropertyChoicesReply | null;
  mistake: string | null;
  change: (condition: string) => void;
}

/** A field for a condition in words, with a list of readings that it can begin with. */
function ConditionField({ label, draft, choices, mistake, change }: ConditionProps) {
  const headings = [...new Set(choices?.conditions.map((each) => each.heading) ?? [])];
  const insert = (text: string): void => {
    const now = draft.condition.trim();
    change(now === "" ? text : `${now} and ${text}`);
  };
  return (
    <>
      <PropertyField label={label} mistake={null}>
        <textarea
          rows={2}
          value={draft.condition}
          placeholder="distance(robot, station) is below 5 cm"
          maxLength={1000}
          onInput={(event) => change(event.currentTarget.value.replaceAll("\n", " "))}
        />
      </PropertyField>
      <PropertyField label="" mistake={mistake}>
        <select
          class="small"
          aria-label="Add to the condition"
          value=""
          onChange={(event) => {
            if (event.currentTarget.value !== "") insert(event.currentTarget.value);
            event.currentTarget.value = "";
          }}
        >
          <option value="">{draft.condition.trim() === "" ? "begin with …" : "and …"}</option>
          {headings.map((heading) => (
            <optgroup key={heading} label={heading}>
              {choices?.conditions
                .filter((each) => each.heading === heading)
                .map(({ text }) => (
                  <option key={text} value={text}>
                    {text}
                  </option>
                ))}
            </optgroup>
          ))}
        </select>
      </PropertyField>
    </>
  );
}

interface ChoiceProps {
  value: string;
  among: readonly string[];
  choose: (value: string) => void;
}

function Choice({ value, among, choose }: ChoiceProps) {
  return <Select value={value} among={among.includes(value) ? among : [value, ...among]} change={choose} />;
}

function NumberInput({ value, change }: { value: number | null; change: (value: number | null) => void }) {
  const [text, setText] = useState(value === null ? "" : String(value));
  useEffect(() => {
    if (value !== null && Number(text) !== value) setText(String(value));
  }, [value]);
  return (
    <Input
      inputMode="decimal"
      value={text}
      change={(written) => {
        const number = Number(written.replace(",", "."));
        setText(written);
        change(written.trim() === "" || Number.isNaN(number) ? null : number);
      }}
    />
  );
}
