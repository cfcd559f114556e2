// What is said of a character within a whole work: on its card over the picture, and on its own page.

import { localize } from "../i18n";
import { t } from "../i18n/whole";
import type { CharacterWithin, Place, Work } from "../types";
import { Facts } from "../ui";
import { UNKNOWN } from "./wholeWork";

const SURE = 0.5; // certainty below which a reading is called uncertain

export const pageOf = (id: string): string => `#/works/${encodeURIComponent(id)}`;
export const gatherPage = (character: string): string => `#/characters/${encodeURIComponent(character)}`;

export function placeInWords(place: Place): string {
  return t(place.direction === "vertical" ? "place" : "placeInRow", { column: place.column + 1, row: place.row + 1 });
}

/** The card of a character that was chosen on the picture or in the text. */
export function CharacterCard({ one }: { one: CharacterWithin }) {
  return (
    <div class="character-card">
      <h3 lang="zh-Hant">{one.character || UNKNOWN}</h3>
      <p><Facts items={[placeInWords(one.place), one.character !== "" && one.place.certainty < SURE && t("uncertain")]} /></p>
      <p class="links">
        <a class="button" href={pageOf(one.id)}>{t("openCharacter")}</a>
        {one.character && <a class="button quiet" href={`#/studio/${encodeURIComponent(one.id)}`}>{t("copyCharacter")}</a>}
        {one.character && <a href={gatherPage(one.character)}>{t("otherHands", { c: one.character })}</a>}
      </p>
    </div>
  );
}

/** On the page of a character: the whole work that it stands in, its brothers there, and those by other hands. */
export function CharacterLinks({ work }: { work: Work }) {
  const { within } = work;
  if (!work.character && !within) return null;
  return (
    <section class="within">
      {within && (
        <p>
          {t("within")} <a href={`${pageOf(within.id)}?at=${encodeURIComponent(work.id)}`}>{localize(within.title)}</a> <small class="note">{placeInWords(within.place)}</small>
        </p>
      )}
      {within && within.same.length > 1 && (
        <nav aria-label={t("same")}>
          <h2>{t("same")}</h2>
          <ol class="same">
            {within.same.map((id, k) => (
              <li key={id}>
                <a href={pageOf(id)} aria-current={id === work.id ? "page" : undefined} aria-label={t("sameOf", { k: k + 1 })}>{k + 1}</a>
              </li>
            ))}
          </ol>
        </nav>
      )}
      {work.character && [...work.character].length === 1 && <p><a href={gatherPage(work.character)}>{t("otherHands", { c: work.character })}</a></p>}
    </section>
  );
}
