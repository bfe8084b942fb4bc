/** Parts of the form of an automaton: what parameters stand for, chips to choose from, options. */

import type { ComponentChildren } from "preact";
import { splitNames, type Offer } from "../calls";
import { Field, Input, Option, Select } from "../fields";
import type { Draft } from "../draft";
import type { Scene } from "../protocol";
import { plain } from "../words";

interface PartProps {
  draft: Draft;
  change: (part: Partial<Draft>) => void;
}

export function Bindings({ draft, scene, change }: PartProps & { scene: Scene }) {
  return (
    <>
      {splitNames(draft.parameters).map((parameter) => (
        <Field key={parameter} label={`${parameter} stands for`} about="while you teach">
          <Select
            value={draft.targets[parameter] ?? scene.targets[0] ?? ""}
            among={scene.targets}
            change={(target) => change({ targets: { ...draft.targets, [parameter]: target } })}
          />
        </Field>
      ))}
    </>
  );
}

export function Options({ draft, change }: PartProps) {
  return (
    <fieldset>
      <legend>Options</legend>
      <Option checked={draft.watched} change={(watched) => change({ watched })}>
        Learn from silence: while you watch and do not press, what it does counts as right.
      </Option>
      <Option checked={draft.unlearning} change={(unlearning) => change({ unlearning })}>
        Unlearning: a correction puts bad examples behind the mistake in quarantine.
      </Option>
      <Option checked={!draft.live} change={(asInPaper) => change({ live: !asInPaper })}>
        Training as in the paper: it does what you told it last, and decides only when you try it.
      </Option>
      <Field label="Reaction time" about="how late your presses come, s">
        <Input value={draft.reaction} inputMode="decimal" change={(reaction) => change({ reaction })} />
      </Field>
    </fieldset>
  );
}

interface ChoicesProps {
  legend: ComponentChildren;
  offers: readonly Offer[];
  chosen: readonly string[];
  choose: (chosen: readonly string[]) => void;
  children?: ComponentChildren;
}

export function Choices({ legend, offers, chosen, choose, children }: ChoicesProps) {
  const alone = offers.filter((offer) => offer.ways.length === 1);
  const several = offers.filter((offer) => offer.ways.length > 1);
  const chip = (way: string, short: string) => {
    const times = chosen.filter((each) => each === way).length;
    return (
      <label class="chip" key={way}>
        <input
          type="checkbox"
          aria-label={plain(way)}
          checked={times > 0}
          onChange={(event) => {
            choose(event.currentTarget.checked ? [...chosen, way] : chosen.filter((each) => each !== way));
          }}
        />
        {plain(short)}
        {times > 1 && ` × ${times}`}
      </label>
    );
  };
  return (
    <fieldset>
      <legend>{legend}</legend>
      {several.map((offer) => (
        <div class="chips-named" key={offer.name}>
          <span class="cut">{plain(offer.name)}</span>
          <div class="flex wrap chips">
            {offer.ways.map((way) => chip(way, way.slice(offer.name.length + 1, -1)))}
          </div>
        </div>
      ))}
      {alone.length > 0 && (
        <div class="flex wrap chips">{alone.map(({ ways: [way = ""] }) => chip(way, way))}</div>
      )}
      {children}
    </fieldset>
  );
}
