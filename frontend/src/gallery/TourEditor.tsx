import { useState } from "preact/hooks";
import { patch, remove } from "../api";
import { common, localize } from "../i18n";
import { t } from "../i18n/gallery";
import { navigate } from "../router";
import type { Tour, TourStep, WorkCard } from "../types";
import { ErrorMessage, Field } from "../ui";
import { Icon } from "../viewer/Icon";
import { BilingualFields } from "./NoteForm";
import { withoutNumber } from "./labels";
import { WorkPicker } from "./WorkPicker";

type Props = { tour: Tour; at: number; onMove: (to: number) => void; onChange: (tour: Tour) => void; view: () => string };

/** Where an owner edits a tour: turn the work as it should be seen, save that view, write a text for it. */
export function TourEditor({ tour, at, onMove, onChange, view }: Props) {
  const [picking, setPicking] = useState(false);
  const [message, setMessage] = useState("");
  const [error, setError] = useState<unknown>(null);
  const step = tour.steps[at];
  const steps = (next: TourStep[]) => {
    setMessage("");
    onChange({ ...tour, steps: next });
  };
  const change = (partial: Partial<TourStep>) => steps(tour.steps.map((s, k) => (k === at ? { ...s, ...partial } : s)));
  const add = (work: WorkCard) => {
    setPicking(false);
    steps([...tour.steps, { work: work.id, view: "", title: work.title, text: { zh: "", en: "" } }]);
    onMove(tour.steps.length);
  };
  const swap = (other: number) => {
    steps(tour.steps.map((s, k) => (k === at ? tour.steps[other]! : k === other ? tour.steps[at]! : s)));
    onMove(other);
  };
  const attempt = async (act: () => Promise<void>) => {
    setError(null);
    await act().catch(setError);
  };
  const save = () => attempt(async () => {
    await patch(`api/tours/${encodeURIComponent(tour.id)}`, { title: tour.title, steps: tour.steps });
    setMessage(t("saved"));
  });
  const deleteTour = () => attempt(async () => {
    if (!confirm(t("sureRemove"))) return;
    await remove(`api/tours/${encodeURIComponent(tour.id)}`);
    navigate("/tours");
  });
  return (
    <section class="tour-editor">
      <Field label={t("titleZh")}><input lang="zh-Hant" value={tour.title.zh} onInput={(e) => onChange({ ...tour, title: { ...tour.title, zh: e.currentTarget.value } })} /></Field>
      <Field label={t("titleEn")}><input lang="en" value={tour.title.en} onInput={(e) => onChange({ ...tour, title: { ...tour.title, en: e.currentTarget.value } })} /></Field>
      <ol class="step-list">
        {tour.steps.map((s, k) => (
          <li key={k}><button type="button" class="quiet" aria-pressed={k === at} onClick={() => onMove(k)}>{k + 1}. {withoutNumber(localize(s.title))}</button></li>
        ))}
      </ol>
      <button type="button" class="quiet" onClick={() => setPicking(true)}><Icon name="add" />{t("addStep")}</button>
      {step && (
        <fieldset>
          <legend>{t("step", { k: at + 1, n: tour.steps.length })}</legend>
          <div class="step-tools">
            <button type="button" onClick={() => { change({ view: view() }); setMessage(t("taken")); }}><Icon name="camera" />{t("takeView")}</button>
            <button type="button" class="quiet" disabled={at === 0} onClick={() => swap(at - 1)}>{t("up")}</button>
            <button type="button" class="quiet" disabled={at === tour.steps.length - 1} onClick={() => swap(at + 1)}>{t("down")}</button>
            <button type="button" class="quiet" onClick={() => { steps(tour.steps.filter((_, k) => k !== at)); onMove(Math.max(0, at - 1)); }}>{common("remove")}</button>
          </div>
          <BilingualFields title={step.title} text={step.text} onTitle={(title) => change({ title })} onText={(text) => change({ text })} />
        </fieldset>
      )}
      {error ? <ErrorMessage error={error} /> : null}
      <div class="step-tools">
        <button type="button" onClick={() => void save()}>{common("save")}</button>
        <button type="button" class="quiet" onClick={() => void deleteTour()}>{t("removeTour")}</button>
        <span role="status">{message}</span>
      </div>
      {picking && <WorkPicker title={t("chooseWork")} onClose={() => setPicking(false)} onChoose={add} />}
    </section>
  );
}
