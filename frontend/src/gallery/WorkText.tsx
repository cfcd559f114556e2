// The text of a whole work, column by column, linked both ways with its picture.

import { useEffect, useRef } from "preact/hooks";
import { t } from "../i18n/whole";
import type { CharacterWithin } from "../types";
import { type Characters, columnsOf, UNKNOWN } from "./wholeWork";

type Props = Characters & { show: (all: boolean) => void };

const STEPS: Record<string, number> = { ArrowDown: 1, ArrowUp: -1, Home: -Infinity, End: Infinity };

export function WorkText({ characters, lit, chosen, shown, light, choose, show }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const columns = columnsOf(characters);
  const vertical = characters[0]?.place.direction !== "horizontal";
  useEffect(() => {
    const there = chosen && box.current?.querySelector<HTMLElement>(`[data-id="${CSS.escape(chosen.id)}"]`);
    if (there) scrollWithin(box.current!, there);
  }, [chosen]);
  const first = chosen ?? characters[0];
  /** Arrow keys go through the text, so that it takes one stop of the tabulator and not one for each character. */
  const keys = (event: KeyboardEvent) => {
    const across = vertical ? { ArrowLeft: 1, ArrowRight: -1 } : { ArrowRight: 1, ArrowLeft: -1 };
    const step = STEPS[event.key];
    const over = across[event.key as keyof typeof across];
    const at = characters.findIndex((one) => one.id === (document.activeElement as HTMLElement | null)?.dataset.id);
    if (at < 0 || (step === undefined && over === undefined)) return;
    event.preventDefault();
    const next = step !== undefined ? characters[Math.max(0, Math.min(characters.length - 1, at + step))] : beside(columns, characters[at]!, over!);
    if (next) box.current?.querySelector<HTMLElement>(`[data-id="${CSS.escape(next.id)}"]`)?.focus();
  };
  return (
    <section class="work-text panel" aria-label={t("text")}>
      <header>
        <h2>{t("text")}</h2>
        <label class="check"><input type="checkbox" checked={shown} onChange={(event) => show(event.currentTarget.checked)} />{t("showBoxes")}</label>
      </header>
      <div class={vertical ? "columns vertical" : "columns"} ref={box} lang="zh-Hant" onKeyDown={keys} onPointerLeave={() => light(null)}>
        {columns.map((column) => (
          <p key={column[0]!.id}>
            {column.map((one) => (
              <button key={one.id} type="button" data-id={one.id} tabIndex={one === first ? 0 : -1} aria-pressed={one === chosen}
                class={`${one === lit ? "lit " : ""}${one.place.small === null ? "" : "small"}`} aria-label={one.character ? undefined : t("unknown")}
                onPointerEnter={() => light(one)} onFocus={() => light(one)} onClick={() => choose(one === chosen ? null : one)}>
                {one.character || UNKNOWN}
              </button>
            ))}
          </p>
        ))}
      </div>
    </section>
  );
}

/** The character at the same height of the next column, or of the one before. */
function beside(columns: CharacterWithin[][], one: CharacterWithin, step: number): CharacterWithin | undefined {
  const at = columns.findIndex((column) => column.includes(one));
  const next = columns[at + step];
  return next?.[Math.min(columns[at]!.indexOf(one), next.length - 1)];
}

/** Scrolls the box and never the page. */
function scrollWithin(box: HTMLElement, there: HTMLElement): void {
  const [outer, inner] = [box.getBoundingClientRect(), there.getBoundingClientRect()];
  if (inner.left < outer.left || inner.right > outer.right) box.scrollBy({ left: inner.left + inner.width / 2 - outer.left - outer.width / 2 });
  if (inner.top < outer.top || inner.bottom > outer.bottom) box.scrollBy({ top: inner.top + inner.height / 2 - outer.top - outer.height / 2 });
}
