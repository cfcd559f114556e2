import { useState } from "preact/hooks";
import { patch, post } from "../api";
import { common } from "../i18n";
import { t } from "../i18n/gallery";
import type { Annotation, Bilingual } from "../types";
import { Dialog, ErrorMessage, Field } from "../ui";

const EMPTY: Bilingual = { zh: "", en: "" };

export function NoteForm({ work, note, onClose, onSaved }: { work: string; note: Partial<Annotation>; onClose: () => void; onSaved: (note: Annotation) => void }) {
  const [title, setTitle] = useState(note.title ?? EMPTY);
  const [text, setText] = useState(note.text ?? EMPTY);
  const [error, setError] = useState<unknown>(null);
  const save = async (event: Event) => {
    event.preventDefault();
    const url = `api/works/${encodeURIComponent(work)}/annotations`;
    const body = { x: note.x, y: note.y, title, text };
    try {
      onSaved(await (note.id ? patch<Annotation>(`${url}/${note.id}`, body) : post<Annotation>(url, body)));
    } catch (problem) {
      setError(problem);
    }
  };
  return (
    <Dialog title={t(note.id ? "editNote" : "addNote")} onClose={onClose}>
      <form onSubmit={(event) => void save(event)}>
        <BilingualFields title={title} text={text} onTitle={setTitle} onText={setText} />
        {error ? <ErrorMessage error={error} /> : null}
        <button type="submit">{common("save")}</button>
      </form>
    </Dialog>
  );
}

type BilingualProps = { title: Bilingual; text: Bilingual; onTitle: (text: Bilingual) => void; onText: (text: Bilingual) => void };

/** A title and a text in both languages. */
export function BilingualFields({ title, text, onTitle, onText }: BilingualProps) {
  return (
    <div class="both">
      <Field label={t("titleZh")}><input lang="zh-Hant" value={title.zh} maxLength={200} required={!title.en} onInput={(e) => onTitle({ ...title, zh: e.currentTarget.value })} /></Field>
      <Field label={t("titleEn")}><input lang="en" value={title.en} maxLength={200} onInput={(e) => onTitle({ ...title, en: e.currentTarget.value })} /></Field>
      <Field label={t("textZh")}><textarea lang="zh-Hant" rows={3} value={text.zh} onInput={(e) => onText({ ...text, zh: e.currentTarget.value })} /></Field>
      <Field label={t("textEn")}><textarea lang="en" rows={3} value={text.en} onInput={(e) => onText({ ...text, en: e.currentTarget.value })} /></Field>
    </div>
  );
}
