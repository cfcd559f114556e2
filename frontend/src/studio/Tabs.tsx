// Tabs after the ARIA pattern: arrow keys move, and only the chosen tab is in the tab order.

import { useRef } from "preact/hooks";
import type { ComponentChildren } from "preact";

type Props<K extends string> = {
  names: readonly K[];
  chosen: K;
  onChoose: (name: K) => void;
  label: string;
  title: (name: K) => string;
  children: ComponentChildren;
};

export function Tabs<K extends string>({ names, chosen, onChoose, label, title, children }: Props<K>) {
  const row = useRef<HTMLDivElement>(null);
  const step = (event: KeyboardEvent) => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    const next = (names.indexOf(chosen) + by + names.length) % names.length;
    onChoose(names[next]!);
    (row.current?.children[next] as HTMLElement | undefined)?.focus();
  };
  return (
    <>
      <div ref={row} class="tabs" role="tablist" aria-label={label} onKeyDown={step}>
        {names.map((name) => (
          <button
            key={name} type="button" role="tab" id={`tab-${name}`} aria-controls={`panel-${name}`}
            aria-selected={name === chosen} tabIndex={name === chosen ? 0 : -1} onClick={() => onChoose(name)}
          >
            {title(name)}
          </button>
        ))}
      </div>
      <div role="tabpanel" id={`panel-${chosen}`} aria-labelledby={`tab-${chosen}`}>
        {children}
      </div>
    </>
  );
}
