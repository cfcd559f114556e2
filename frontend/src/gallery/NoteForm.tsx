import { useState } from "preact/hooks";
import { patch, post } from "../api";
import { t as common, words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import type { Annotation, Text } from "../types";
import { Dialog, Field, Trouble } from "../ui";

const t = words(table);
const EMPTY: Text = { zh: "", en: "" };

export function NoteForm({ work, note, onClose, onSaved }: { work: string; note: Partial<Annotation>; onClose: () => void; onSaved: (note: Annotation) => void }) {
  const [title, setTitle] = useState(note.title ?? EMPTY);
  const [text, setText] = useState(note.text ?? EMPTY);
  const [error, setError] = useState<unknown>(null);
  const save = async (event: Event) => {
    event.preventDefault();
    const url = `/api/works/${encodeURIComponent(work)}/annotations`;
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
        <BothTexts title={title} text={text} onTitle={setTitle} onText={setText} />
        {error ? <Trouble error={error} /> : null}
        <button type="submit">{common("save")}</button>
      </form>
    </Dialog>
  );
}

type BothProps = { title: Text; text: Text; onTitle: (text: Text) => void; onText: (text: Text) => void };

/** A title and a text in both languages. */
export function BothTexts({ title, text, onTitle, onText }: BothProps) {
  return (
    <div class="both">
      <Field label={t("titleZh")}><input lang="zh-Hant" value={title.zh} maxLength={200} required={!title.en} onInput={(e) => onTitle({ ...title, zh: e.currentTarget.value })} /></Field>
      <Field label={t("titleEn")}><input lang="en" value={title.en} maxLength={200} onInput={(e) => onTitle({ ...title, en: e.currentTarget.value })} /></Field>
      <Field label={t("textZh")}><textarea lang="zh-Hant" rows={3} value={text.zh} onInput={(e) => onText({ ...text, zh: e.currentTarget.value })} /></Field>
      <Field label={t("textEn")}><textarea lang="en" rows={3} value={text.en} onInput={(e) => onText({ ...text, en: e.currentTarget.value })} /></Field>
    </div>
  );
}
