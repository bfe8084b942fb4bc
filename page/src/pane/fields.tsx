/** The fields of the form: names, what parameters stand for, chips to choose from, options. */

import type { ComponentChildren } from "preact";
import { splitNames, type Offer } from "../calls";
import type { Draft } from "../draft";
import type { Scene } from "../protocol";
import { plain } from "../words";

interface FieldProps {
  label: string;
  value: string;
  hint: string;
  about?: string;
  change: (value: string) => void;
}

export function Field({ label, value, hint, about, change }: FieldProps) {
  return (
    <label class="field">
      <span>{label}</span>
      <input
        value={value}
        placeholder={hint}
        spellcheck={false}
        autocomplete="off"
        onInput={(event) => change(event.currentTarget.value)}
      />
      {about !== undefined && <span class="tiny">{about}</span>}
    </label>
  );
}

interface PartProps {
  draft: Draft;
  change: (part: Partial<Draft>) => void;
}

export function Bindings({ draft, scene, change }: PartProps & { scene: Scene }) {
  return (
    <>
      {splitNames(draft.parameters).map((parameter) => (
        <label class="field" key={parameter}>
          <span>{parameter} stands for</span>
          <select
            value={draft.targets[parameter] ?? scene.targets[0] ?? ""}
            onChange={(event) => {
              change({ targets: { ...draft.targets, [parameter]: event.currentTarget.value } });
            }}
          >
            {scene.targets.map((target) => (
              <option key={target} value={target}>
                {plain(target)}
              </option>
            ))}
          </select>
          <span class="tiny">while you teach</span>
        </label>
      ))}
    </>
  );
}

export function Options({ draft, change }: PartProps) {
  return (
    <fieldset>
      <legend>Options</legend>
      <label class="option">
        <input
          type="checkbox"
          checked={draft.watched}
          onChange={(event) => change({ watched: event.currentTarget.checked })}
        />
        Learn from silence: while you watch and do not press, what it does counts as right.
      </label>
      <label class="option">
        <input
          type="checkbox"
          checked={draft.unlearning}
          onChange={(event) => change({ unlearning: event.currentTarget.checked })}
        />
        Unlearning: a correction puts bad examples behind the mistake in quarantine.
      </label>
      <label class="option">
        <input
          type="checkbox"
          checked={!draft.live}
          onChange={(event) => change({ live: !event.currentTarget.checked })}
        />
        Training as in the paper: it does what you told it last, and decides only when you try it.
      </label>
      <label class="field">
        <span>Reaction time</span>
        <input
          value={draft.reaction}
          inputMode="decimal"
          onInput={(event) => change({ reaction: event.currentTarget.value })}
        />
        <span class="tiny">how late your presses come, s</span>
      </label>
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
          <div class="chips">{offer.ways.map((way) => chip(way, way.slice(offer.name.length + 1, -1)))}</div>
        </div>
      ))}
      {alone.length > 0 && <div class="chips">{alone.map(({ ways: [way = ""] }) => chip(way, way))}</div>}
      {children}
    </fieldset>
  );
}
