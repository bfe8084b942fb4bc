/** The states of a form: behaviors to choose from and, on request, their names and further states with one behavior. */

import { useState } from "preact/hooks";
import { Button, CloseButton } from "../button";
import { chooseState as fresh, duplicateState, stateNames, type StateChoice, type Offer } from "../calls";
import { Input } from "../fields";
import { Choices } from "./options";
import { plain } from "../words";

interface StatesProps {
  offers: readonly Offer[];
  chosen: readonly StateChoice[];
  choose: (chosen: readonly StateChoice[]) => void;
}

export function States({ offers, chosen, choose }: StatesProps) {
  const [opened, setOpened] = useState(() => hasNames(chosen));
  const showsNames = opened && chosen.length > 0;
  const runs = chosen.map((state) => state.runs);
  const chooseRuns = (now: readonly string[]): void => {
    const added = now.filter((each) => !runs.includes(each));
    choose([...chosen.filter((state) => now.includes(state.runs)), ...added.map(fresh)]);
  };
  const legend = (
    <>
      States: what it can do
      {chosen.length > 0 && (
        <>
          {" · "}
          <Button
            class="link"
            aria-label="Names of the states"
            aria-expanded={showsNames}
            title="Give states other names, or take a behavior once more"
            onClick={() => setOpened(!opened)}
          >
            names
          </Button>
        </>
      )}
    </>
  );
  return (
    <Choices legend={legend} offers={offers} chosen={runs} choose={chooseRuns}>
      {showsNames && <Names chosen={chosen} choose={choose} />}
    </Choices>
  );
}

/** Whether names matter here: one was given, or a behavior was taken twice. */
function hasNames(chosen: readonly StateChoice[]): boolean {
  const plain = stateNames(chosen.map(({ runs }) => fresh(runs)));
  return stateNames(chosen).some((name, index) => name !== plain[index]);
}

function Names({ chosen, choose }: Omit<StatesProps, "offers">) {
  const names = stateNames(chosen);
  const unnamed = stateNames(chosen.map((state) => ({ ...state, name: "" })));
  const change = (index: number, name: string): void =>
    choose(chosen.map((state, at) => (at === index ? { ...state, name } : state)));
  return (
    <ul class="state-names">
      {chosen.map((state, index) => (
        <li key={index}>
          <Input
            aria-label={`Name of the state ${index + 1}, which runs ${plain(state.runs)}`}
            value={state.name}
            placeholder={unnamed[index]}
            change={(name) => change(index, name)}
          />
          <span class="tiny cut">runs {plain(state.runs)}</span>
          <Button
            class="link"
            aria-label={`${plain(state.runs)} once more`}
            title="Duplicate state"
            onClick={() => choose(duplicateState(chosen, index))}
          >
            once more
          </Button>
          <CloseButton
            class="link"
            label={`Leave out ${plain(names[index] ?? "")}`}
            onClick={() => choose(chosen.filter((_, at) => at !== index))}
          />
        </li>
      ))}
    </ul>
  );
}
