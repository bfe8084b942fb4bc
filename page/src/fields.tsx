/** Forms and their fields: what is typed, chosen and ticked. */

import type {
  ComponentChildren,
  FormHTMLAttributes,
  InputHTMLAttributes,
  SelectHTMLAttributes,
} from "preact";
import { useStudio } from "./context";
import { plain } from "./words";

interface FormProps extends FormHTMLAttributes<HTMLFormElement> {
  submit: () => void;
}

/** A form that is sent by the page itself. */
export function Form({ submit, ...rest }: FormProps) {
  const send = (event: Event): void => {
    event.preventDefault();
    submit();
  };
  return <form {...rest} onSubmit={send} />;
}

interface FieldProps {
  label: string;
  /** What it means, as part of its label. */
  about?: string;
  children: ComponentChildren;
}

/** A field beside its label. */
export function Field({ label, about, children }: FieldProps) {
  return (
    <label class="field">
      <span>{label}</span>
      {children}
      {about !== undefined && <span class="tiny">{about}</span>}
    </label>
  );
}

type InputProps = InputHTMLAttributes<HTMLInputElement> & { change: (text: string) => void };

/** A line of text: names and numbers, which no browser can correct or complete. */
export function Input({ change, ...rest }: InputProps) {
  return (
    <input
      spellcheck={false}
      autocomplete="off"
      {...rest}
      onInput={(event) => change(event.currentTarget.value)}
    />
  );
}

interface OptionProps {
  checked: boolean;
  change: (checked: boolean) => void;
  children: ComponentChildren;
}

export function Option({ checked, change, children }: OptionProps) {
  return (
    <label class="option">
      <input type="checkbox" checked={checked} onChange={(event) => change(event.currentTarget.checked)} />
      {children}
    </label>
  );
}

type SelectProps = SelectHTMLAttributes<HTMLSelectElement> & {
  value: string;
  /** What can be chosen: values, or pairs of a value and what it is called. */
  among: readonly (string | readonly [value: string, label: string])[];
  change: (value: string, select: HTMLSelectElement) => void;
};

export function Select({ among, change, ...rest }: SelectProps) {
  return (
    <select {...rest} onChange={({ currentTarget }) => change(currentTarget.value, currentTarget)}>
      {among.map((each) => {
        const [value, label] = typeof each === "string" ? [each, plain(each)] : each;
        return (
          <option key={value} value={value}>
            {label}
          </option>
        );
      })}
    </select>
  );
}

/** A choice that the server makes: what it is now is shown until the server says so, and keys are the page's again. */
export function ControlSelect({ change, ...rest }: SelectProps) {
  const choose = (value: string, select: HTMLSelectElement): void => {
    select.value = rest.value;
    select.blur();
    change(value, select);
  };
  return <Select {...rest} disabled={!useStudio().hasControl} change={choose} />;
}
