// One of few values, chosen by radio buttons that look like buttons.

import type { ComponentChildren } from "preact";

type Props<T extends string> = {
  label: string;
  /** Of the group of radio buttons, unique on the page. */
  name: string;
  values: readonly T[];
  chosen: T;
  onChoose: (value: T) => void;
  title: (value: T) => ComponentChildren;
};

export function Choices<T extends string>({ label, name, values, chosen, onChoose, title }: Props<T>) {
  return (
    <fieldset class="choices">
      <legend>{label}</legend>
      {values.map((value) => (
        <label key={value}>
          <input type="radio" name={name} checked={chosen === value} onChange={() => onChoose(value)} />
          <span>{title(value)}</span>
        </label>
      ))}
    </fieldset>
  );
}
