// What an owner can do with a collection: give it a title, a text, a cover and a tour, or delete it.

import { useState } from "preact/hooks";
import { get, patch, remove } from "../api";
import { common, localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { Collection, Exhibition, Tour } from "../types";
import { Dialog, ErrorMessage, Field, useLoaded } from "../ui";
import { licenceField } from "./licences";
import { clearLastList } from "./listState";
import { WorkPicker } from "./WorkPicker";

type Props = { item: Collection; onChange: () => void };

export function CollectionTools({ item, onChange }: Props) {
  const [doing, setDoing] = useState<"" | "edit" | "delete">("");
  const done = () => {
    setDoing("");
    clearLastList();
    onChange();
  };
  return (
    <p class="row">
      <button type="button" class="quiet small" aria-label={t("editOf", { title: localize(item.title) })} onClick={() => setDoing("edit")}>{t("edit")}</button>
      <button type="button" class="quiet small" aria-label={t("deleteOf", { title: localize(item.title) })} onClick={() => setDoing("delete")}>{common("remove")}</button>
      {doing === "edit" && <EditDialog item={item} onClose={() => setDoing("")} onSaved={done} />}
      {doing === "delete" && <DeleteDialog item={item} onClose={() => setDoing("")} onDeleted={done} />}
    </p>
  );
}

export const collectionUrl = ({ id }: Pick<Collection, "id">): string => `api/collections/${encodeURIComponent(id)}`;

function EditDialog({ item, onClose, onSaved }: { item: Collection; onClose: () => void; onSaved: () => void }) {
  const [title, setTitle] = useState(item.title);
  const [note, setNote] = useState(item.note);
  const [source, setSource] = useState(item.source);
  const [licence, setLicence] = useState(licenceField(item.licence));
  const [chosen, setChosen] = useState<Choices>({});
  const [error, setError] = useState<unknown>(null);
  const save = (event: Event) => {
    event.preventDefault();
    if (!`${title.zh}${title.en}`.trim()) return setError(new Error(t("collectionTitleNeeded")));
    patch(collectionUrl(item), { title, note, source, ...chosen, ...(licence === licenceField(item.licence) ? {} : { licence }) }).then(onSaved, setError);
  };
  return (
    <Dialog title={t("editCollection")} onClose={onClose}>
      <form class="both" onSubmit={save}>
        <Field label={t("titleZh")}><input lang="zh-Hant" maxLength={200} value={title.zh} onInput={(event) => setTitle({ ...title, zh: event.currentTarget.value })} /></Field>
        <Field label={t("titleEn")}><input lang="en" maxLength={200} value={title.en} onInput={(event) => setTitle({ ...title, en: event.currentTarget.value })} /></Field>
        <Field label={t("aboutZh")}><textarea lang="zh-Hant" rows={3} maxLength={8000} value={note.zh} onInput={(event) => setNote({ ...note, zh: event.currentTarget.value })} /></Field>
        <Field label={t("aboutEn")}><textarea lang="en" rows={3} maxLength={8000} value={note.en} onInput={(event) => setNote({ ...note, en: event.currentTarget.value })} /></Field>
        <Field label={t("source")}><textarea rows={2} maxLength={8000} value={source} onInput={(event) => setSource(event.currentTarget.value)} /></Field>
        <Field label={t("licence")} hint={t("licenceHint")}><input maxLength={200} value={licence} onInput={(event) => setLicence(event.currentTarget.value)} /></Field>
        {item.works > 0 && <CoverAndTour item={item} onChange={(choice) => setChosen({ ...chosen, ...choice })} />}
        {error !== null && <ErrorMessage error={error} />}
        <p class="row">
          <button type="submit">{common("save")}</button>
          <button type="button" class="quiet" onClick={onClose}>{common("cancel")}</button>
        </p>
      </form>
    </Dialog>
  );
}

type Choices = { cover?: string; tour?: string };

/** The work at the head of its page, and the tour that begins there; '' is none. */
function CoverAndTour({ item, onChange }: { item: Collection; onChange: (choice: Choices) => void }) {
  const shown = useLoaded((signal) => get<Exhibition>(collectionUrl(item), signal), item.id);
  const tours = useLoaded((signal) => get<Tour[]>("api/tours", signal), "all");
  const [picking, setPicking] = useState(false);
  const [cover, setCover] = useState<string | null>(null);
  const [tour, setTour] = useState<string | null>(null);
  const now = shown.value;
  if (shown.error || tours.error) return <ErrorMessage error={shown.error ?? tours.error} retry={() => (shown.retry(), tours.retry())} />;
  if (!now || !tours.value) return null;
  const choose = (id: string, title: string) => (setCover(title), onChange({ cover: id }), setPicking(false));
  return (
    <>
      <div class="field">
        <span id="cover-label"><strong>{t("cover")}</strong></span>
        <p class="row">
          <span>{cover ?? (now.chosen && now.cover ? localize(now.cover.title) : t("firstWork"))}</span>
          <button type="button" class="quiet small" aria-describedby="cover-label" onClick={() => setPicking(true)}>{t("chooseWork")}</button>
          <button type="button" class="quiet small" aria-describedby="cover-label" onClick={() => choose("", t("firstWork"))}>{t("firstWork")}</button>
        </p>
      </div>
      <Field label={t("itsTour")}>
        <select value={tour ?? now.tour?.id ?? ""} onChange={(event) => (setTour(event.currentTarget.value), onChange({ tour: event.currentTarget.value }))}>
          <option value="">{t("noTour")}</option>
          {tours.value.map((one) => <option key={one.id} value={one.id}>{localize(one.title)}</option>)}
        </select>
      </Field>
      {picking && <WorkPicker title={t("cover")} collection={item.id} onClose={() => setPicking(false)} onChoose={(work) => choose(work.id, localize(work.title))} />}
    </>
  );
}

/** Says what goes with the collection; the button works once the reader has said that they want that. */
function DeleteDialog({ item, onClose, onDeleted }: { item: Collection; onClose: () => void; onDeleted: () => void }) {
  const [sure, setSure] = useState(item.works === 0);
  const [sending, setSending] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const deleteIt = () => {
    setSending(true);
    remove(collectionUrl(item)).then(onDeleted, (problem: unknown) => (setError(problem), setSending(false)));
  };
  return (
    <Dialog title={t("deleteCollection", { title: localize(item.title) })} onClose={onClose}>
      {item.works === 0 ? (
        <p>{t("deleteCollectionEmpty")}</p>
      ) : (
        <>
          <p>{t("deleteCollectionGoes", { n: item.works.toLocaleString() })}</p>
          <label class="check">
            <input type="checkbox" checked={sure} onChange={(event) => setSure(event.currentTarget.checked)} />
            <span>{t("deleteCollectionSure", { n: item.works.toLocaleString() })}</span>
          </label>
        </>
      )}
      {error !== null && <ErrorMessage error={error} />}
      <p class="row">
        <button type="button" disabled={!sure || sending} onClick={deleteIt}>{common("remove")}</button>
        <button type="button" class="quiet" disabled={sending} onClick={onClose}>{common("cancel")}</button>
      </p>
    </Dialog>
  );
}
