/** The form for a new automaton, and for changing the choices: beside the running world, never over it. */

import { useState } from "preact/hooks";
import { Button, CloseButton, ControlButton } from "../button";
import { findDuplicate } from "../calls";
import { Prompt } from "../confirm";
import { usePanel, useStudio } from "../context";
import { makeDraft, listOffers, parseReaction, makeRequest, type Draft } from "../draft";
import { Field, Form, Input } from "../fields";
import type { Form as FormName } from "../panel";
import type { Scene } from "../protocol";
import type { Studio } from "../studio";
import { formatCount, plain } from "../words";
import { Bindings, Choices, Options } from "./options";
import { States } from "./states";

export function ChoiceForm({ form }: { form: FormName }) {
  const studio = useStudio();
  if (studio.scene === null || studio.status === null) return null;
  return <Fields form={form} scene={studio.scene} />;
}

function Fields({ form, scene }: { form: FormName; scene: Scene }) {
  const studio = useStudio();
  const panel = usePanel();
  const [draft, setDraft] = useState<Draft>(() => makeDraft(form, studio, scene));
  const [asks, setAsks] = useState(false);
  const change = (part: Partial<Draft>): void => setDraft((before) => ({ ...before, ...part }));
  const offered = listOffers(draft, studio, scene);
  const fresh = form === "new";
  const variants = new Set(offered.states.flatMap(({ ways }) => ways));
  const states = fresh ? draft.states.filter(({ runs }) => variants.has(runs)) : draft.states;
  const missing = findMissing({ ...draft, states });
  const send = async (discard: boolean): Promise<void> => {
    if (fresh && hasUnsaved(studio, draft.name) !== null && !discard) return setAsks(true);
    const answer = await studio.ask(makeRequest(form, draft, studio, scene, discard));
    if (answer.error === undefined) panel.open("automaton");
  };
  const saveFirst = async (): Promise<void> => {
    if (await studio.lessonTests.save()) await send(true);
  };
  return (
    <Form class="choice" submit={() => void send(false)}>
      <div class="choice-head">
        <h3>{fresh ? "New automaton" : `What ${plain(draft.name)} is about`}</h3>
        <CloseButton class="link" label="Close the form" onClick={() => panel.choose(null)} />
      </div>
      {fresh && (
        <>
          <Field label="Name">
            <Input value={draft.name} placeholder="goto" change={(name) => change({ name })} />
          </Field>
          <Field label="Parameters" about="left open, to be bound where it is used">
            <Input
              value={draft.parameters}
              placeholder="none; or A"
              change={(parameters) => change({ parameters })}
            />
          </Field>
          <Bindings draft={draft} scene={scene} change={change} />
        </>
      )}
      <States offers={offered.states} chosen={states} choose={(chosen) => change({ states: chosen })} />
      <Field label="Flags" about="states in which it stops, and says so">
        <Input value={draft.flags} placeholder="done" change={(flags) => change({ flags })} />
      </Field>
      <Choices
        legend="Features: what it decides on"
        offers={offered.features}
        chosen={draft.features}
        choose={(features) => change({ features })}
      />
      <Options draft={draft} change={change} />
      {asks ? (
        <Prompt
          answers={{
            ...(studio.session?.unsaved === true && { "Save, then begin": () => void saveFirst() }),
            "Begin without it": () => void send(true),
          }}
        >
          {plain(hasUnsaved(studio, draft.name) ?? "")}
        </Prompt>
      ) : (
        <div class="flex choice-foot">
          <ControlButton type="submit" class="primary" disabled={missing !== null}>
            {fresh ? "Begin" : "Choose"}
          </ControlButton>
          <Button onClick={() => panel.choose(null)}>Not now</Button>
          <span class="tiny">{missing ?? (fresh ? "" : "Examples stay where they can.")}</span>
        </div>
      )}
    </Form>
  );
}

/** What a new automaton would leave unsaved; null if nothing. */
function hasUnsaved(studio: Studio, name: string): string | null {
  const { session, status } = studio;
  if (session?.unsaved === true) return `${session.name} has changes that are not in the library.`;
  const left = status?.library.interrupted.find((each) => each.name === name.trim());
  if (left === undefined) return null;
  return `A lesson of ${left.name} was interrupted with ${formatCount(left.examples, "example")}; the library can resume it.`;
}

/** What is still to be said; null where nothing is. */
function findMissing(draft: Draft): string | null {
  if (draft.name.trim() === "") return "Give it a name.";
  if (draft.states.length === 0) return "Choose at least one state.";
  const same = findDuplicate(draft.states);
  if (same !== null) return `Two states are called ${plain(same)}.`;
  if (draft.features.length === 0) return "Choose at least one feature.";
  return parseReaction(draft) === null
    ? "The reaction time is no number of seconds: 0.3, for example."
    : null;
}
