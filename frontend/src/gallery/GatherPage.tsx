// 集字: one character by all hands that wrote it, by script and time; two of them side by side.

import { useState } from "preact/hooks";
import { get } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/whole";
import { navigate, type PageProps } from "../router";
import type { Bilingual, WorkCard } from "../types";
import { ErrorPage, Facts, Loading, useLoaded } from "../ui";
import { pageOf } from "./CharacterFacts";
import { RelitThumb } from "./GalleryCard";
import { scriptName } from "./labels";
import "./gallery.css";
import "./gather.css";

export type Gathered = {
  character: string;
  total: number;
  hands: number;
  scripts: { script: string; hands: { hand: Bilingual; time: Bilingual; works: WorkCard[] }[] }[];
};

export default function GatherPage({ params }: PageProps) {
  const character = params.character ?? "";
  const loaded = useLoaded((signal) => get<Gathered>(`api/characters/${encodeURIComponent(character)}/works`, signal), character);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value || !loaded.fresh) return <Loading />;
  return <GatheredView key={character} gathered={loaded.value} />;
}

export function GatheredView({ gathered }: { gathered: Gathered }) {
  const [picked, setPicked] = useState<string[]>([]);
  const { character } = gathered;
  /** The last two that were chosen stay. */
  const pick = (id: string) => setPicked((before) => (before.includes(id) ? before.filter((one) => one !== id) : [...before, id].slice(-2)));
  return (
    <div class="gather">
      <header class="page-head">
        <h1>{t("gatherTitle", { c: character })}</h1>
        <p class="lead">{t("gatherLead")}</p>
        <AnotherCharacter />
        {gathered.total > 0 && <p class="count" role="status">{t("gatherCount", { hands: gathered.hands.toLocaleString(), n: gathered.total.toLocaleString() })}</p>}
      </header>
      {gathered.total === 0 && <p class="nothing">{t("gatherNone")}</p>}
      {gathered.scripts.map(({ script, hands }) => (
        <section key={script} class="script">
          <h2>{script ? scriptName(script) : t("unknownScript")}</h2>
          {hands.map(({ hand, time, works }) => (
            <section key={works[0]!.id} class="hand">
              <h3>{localize(hand)} <small><Facts items={[localize(time) || t("unknownTime"), works.length > 1 && t("characters", { n: works.length })]} /></small></h3>
              <ul>
                {works.map((work) => (
                  <li key={work.id} class={picked.includes(work.id) ? "picked" : ""}>
                    <a href={pageOf(work.id)} title={localize(work.title)}><RelitThumb work={work} /><span class="visually-hidden">{localize(work.title)}</span></a>
                    <button type="button" class="quiet" aria-pressed={picked.includes(work.id)} aria-label={t("choose", { title: localize(work.title) })} onClick={() => pick(work.id)}>{picked.includes(work.id) ? "✓" : "＋"}</button>
                  </li>
                ))}
              </ul>
            </section>
          ))}
        </section>
      ))}
      {gathered.total > 1 && (
        <p class="compare-bar" role="status">
          {picked.length === 2
            ? <a class="button" href={`${pageOf(picked[0]!)}?with=${encodeURIComponent(picked[1]!)}`}>{t("compare")}</a>
            : t(picked.length ? "chosenOne" : "pick")}
        </p>
      )}
    </div>
  );
}

function AnotherCharacter() {
  const go = (event: SubmitEvent) => {
    event.preventDefault();
    const text = String(new FormData(event.currentTarget as HTMLFormElement).get("character") ?? "").trim();
    const first = [...text][0];
    if (first) navigate(`/characters/${encodeURIComponent(first)}`);
  };
  return (
    <form class="row" role="search" onSubmit={go}>
      <label><span class="visually-hidden">{t("other")}</span><input name="character" maxLength={8} placeholder={t("other")} lang="zh-Hant" /></label>
    </form>
  );
}
