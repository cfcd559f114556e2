// The page to print a practice sheet: what stands on it, and how it will look.

import { useEffect, useState } from "preact/hooks";
import { get, session } from "../api";
import { loginLink } from "../account/RequireLogin";
import { WorkPicker } from "../gallery/WorkPicker";
import { common, localize } from "../i18n";
import { t } from "../i18n/sheets";
import { type PageProps, replaceQuery } from "../router";
import type { WorkCard } from "../types";
import { ErrorMessage, Field, useDelayed, useLoaded } from "../ui";
import { Choices } from "./Choices";
import { SheetGridIcon } from "./icons";
import { CELL, GRIDS, HELPS, isAsked, LONGEST_PUPIL, MASTERS, MAX_CHARACTERS, MAX_TIMES, PAPER_SIZES, PAPERS, readRequest, requestQuery, type SheetRequest, sheetUrl } from "./request";
import "../studio/studio.css";
import "./sheets.css";

const TYPING_DELAY_MS = 400; // pause after which the preview is drawn anew

type Change = (part: Partial<SheetRequest>) => void;

export default function PrintPage({ query }: PageProps) {
  const [asked, setAsked] = useState(() => readRequest(query));
  const change: Change = (part) => setAsked((old) => ({ ...old, ...part }));
  useEffect(() => replaceQuery(requestQuery(asked)), [asked]);
  return (
    <div class="print-page">
      <header>
        <h1>{t("printTitle")}</h1>
        <p class="lead">{t("printLead")}</p>
      </header>
      <form class="sheet-form panel" onSubmit={(event) => event.preventDefault()}>
        <Field label={t("text")} hint={t("textHint", { most: MAX_CHARACTERS })}>
          <textarea class="sheet-text" lang="zh-Hant" rows={2} maxLength={2 * MAX_CHARACTERS} value={asked.text} onInput={(event) => change({ text: event.currentTarget.value })} />
        </Field>
        <MasterFields asked={asked} onChange={change} />
        <LookFields asked={asked} onChange={change} />
        <PupilFields asked={asked} onChange={change} />
      </form>
      <Preview asked={asked} />
    </div>
  );
}

function MasterFields({ asked, onChange }: { asked: SheetRequest; onChange: Change }) {
  const [picking, setPicking] = useState(false);
  const add = (work: WorkCard) => {
    setPicking(false);
    if (!asked.works.includes(work.id)) onChange({ works: [...asked.works, work.id] });
  };
  return (
    <>
      <Field label={t("masters")}>
        <select value={asked.master} onChange={(event) => onChange({ master: event.currentTarget.value as SheetRequest["master"] })}>
          {MASTERS.map((name) => (
            <option key={name} value={name}>
              {name === "strokes" ? t("strokes") : t("starter", { script: common(name) })}
            </option>
          ))}
        </select>
      </Field>
      <fieldset class="chosen-works">
        <legend>{t("works")}</legend>
        {asked.works.map((id) => (
          <ChosenWork key={id} id={id} onOut={() => onChange({ works: asked.works.filter((one) => one !== id) })} />
        ))}
        {session.value?.person ? (
          <button type="button" class="quiet" onClick={() => setPicking(true)}>＋ {t("addWork")}</button>
        ) : (
          <p class="note">
            {t("worksNeedLogin")} <a href={loginLink()}>{common("login")}</a>
          </p>
        )}
      </fieldset>
      {picking && <WorkPicker title={t("addWork")} masters onClose={() => setPicking(false)} onChoose={add} />}
    </>
  );
}

function ChosenWork({ id, onOut }: { id: string; onOut: () => void }) {
  const { value } = useLoaded((signal) => get<WorkCard>(`api/works/${encodeURIComponent(id)}`, signal), id);
  const title = value ? localize(value.title) : id;
  return (
    <span class="chosen-work">
      {value && <img src={value.thumb} alt={title} width="48" height="48" />}
      <button type="button" class="quiet small" aria-label={t("takeWorkOut", { title })} onClick={onOut}>×</button>
    </span>
  );
}

function LookFields({ asked, onChange }: { asked: SheetRequest; onChange: Change }) {
  return (
    <>
      <Choices label={t("help")} name="model" values={HELPS} chosen={asked.model} onChoose={(model) => onChange({ model })} title={(one) => t(`help_${one}`)} />
      <Choices
        label={t("grid")} name="grid" values={GRIDS} chosen={asked.grid} onChoose={(grid) => onChange({ grid })}
        title={(one) => <><SheetGridIcon grid={one} />{t(`grid_${one}`)}</>}
      />
      <Choices label={t("paper")} name="paper" values={PAPERS} chosen={asked.paper} onChoose={(paper) => onChange({ paper })} title={(one) => t(one)} />
      <label class="slider">
        <span>{t("cell")}</span>
        <input
          type="range" min={CELL.min} max={CELL.max} step="1" value={asked.cell} aria-valuetext={t("millimetres", { n: asked.cell })}
          onInput={(event) => onChange({ cell: Number(event.currentTarget.value) })}
        />
        <span class="number">{t("millimetres", { n: asked.cell })}</span>
      </label>
      <div class="row">
        <Field label={t("times")} hint={t("timesHint")}>
          <input
            type="number" min="0" max={MAX_TIMES} value={asked.times}
            onInput={(event) => onChange({ times: Math.min(MAX_TIMES, Math.max(0, Math.round(Number(event.currentTarget.value) || 0))) })}
          />
        </Field>
        <label class="check">
          <input type="checkbox" checked={asked.strokes} onChange={(event) => onChange({ strokes: event.currentTarget.checked })} />
          <span>{t("order")}</span>
        </label>
      </div>
    </>
  );
}

type ClassName = { id: string; name: string };

function PupilFields({ asked, onChange }: { asked: SheetRequest; onChange: Change }) {
  const person = session.value?.person;
  const teaches = person !== null && person !== undefined && person.role !== "pupil";
  const loaded = useLoaded((signal) => (teaches ? get<ClassName[]>("api/classes", signal) : Promise.resolve([])), String(teaches));
  const classes = loaded.value ?? [];
  return (
    <>
      {!asked.class && (
        <Field label={t("pupil")} hint={t("pupilHint")}>
          <input maxLength={LONGEST_PUPIL} value={asked.pupil} onInput={(event) => onChange({ pupil: event.currentTarget.value })} />
        </Field>
      )}
      {classes.length > 0 && (
        <Field label={t("forClass")}>
          <select value={asked.class} onChange={(event) => onChange({ class: event.currentTarget.value })}>
            <option value="">{t("noClass")}</option>
            {classes.map((one) => (
              <option key={one.id} value={one.id}>{one.name}</option>
            ))}
          </select>
        </Field>
      )}
    </>
  );
}

type Plan = { sheet: string; pages: number; cells: number; times: number; text: string };

function Preview({ asked }: { asked: SheetRequest }) {
  const rested = useDelayed(asked, TYPING_DELAY_MS);
  const url = isAsked(rested) ? sheetUrl(rested, "") : "";
  const loaded = useLoaded((signal) => (url ? get<Plan>(url, signal) : Promise.resolve(null)), url);
  const [number, setNumber] = useState(1);
  const plan = loaded.fresh ? (loaded.value ?? null) : null;
  useEffect(() => setNumber(1), [url]);
  return (
    <section class="print-preview" aria-label={t("preview")} aria-busy={url !== "" && !loaded.fresh}>
      {loaded.error && loaded.fresh ? <ErrorMessage error={loaded.error} /> : !url ? <p class="note">{t("nothingYet")}</p> : null}
      {plan && (
        <>
          <div class="row">
            <a class="button" href={sheetUrl(rested, ".pdf")} download="practice-sheet.pdf">{t("download")}</a>
            {plan.pages > 1 && (
              <>
                <button type="button" class="quiet" disabled={number <= 1} aria-label={t("before")} onClick={() => setNumber(number - 1)}>‹</button>
                <span class="number">{t("pageOf", { n: number, pages: plan.pages })}</span>
                <button type="button" class="quiet" disabled={number >= plan.pages} aria-label={t("after")} onClick={() => setNumber(number + 1)}>›</button>
              </>
            )}
          </div>
          <p class="note" role="status">{t("holds", { characters: [...plan.text].length, cells: plan.cells, pages: plan.pages })}</p>
          <img
            class="sheet-page" src={sheetUrl(rested, ".png", number)} alt={t("previewAlt", { n: number, pages: plan.pages })}
            {...PAPER_SIZES[rested.paper]}
          />
          <p class="note">{t("printAdvice")}</p>
        </>
      )}
    </section>
  );
}
