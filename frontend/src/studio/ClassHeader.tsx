// The name of a class, which its teacher can change, and its deletion, which first says what is deleted and what stays.

import { useEffect, useRef, useState } from "preact/hooks";
import { patch, remove, session } from "../api";
import { common } from "../i18n";
import { t } from "../i18n/studio";
import { navigate } from "../router";
import { Dialog, ErrorMessage, Field } from "../ui";

type ClassInfo = { id: string; name: string; pupils: number; tasks: number };

/** The head of a class page for a teacher. */
export function ClassHeader({ onChange, ...head }: ClassInfo & { onChange: () => void }) {
  const [doing, setDoing] = useState<"" | "rename" | "delete">("");
  const close = () => setDoing("");
  return (
    <header class="page-head">
      <h1>{head.name}</h1>
      <p class="row">
        <button type="button" class="quiet small" onClick={() => setDoing("rename")}>{t("renameClass")}</button>
        <button type="button" class="quiet small" onClick={() => setDoing("delete")}>{t("deleteClass")}</button>
      </p>
      {doing === "rename" && <RenameDialog {...head} onClose={close} onSaved={() => (close(), onChange())} />}
      {doing === "delete" && <DeleteDialog {...head} onClose={close} />}
    </header>
  );
}

function RenameDialog({ id, name, onClose, onSaved }: ClassInfo & { onClose: () => void; onSaved: () => void }) {
  const first = useFocused<HTMLInputElement>();
  const [text, setText] = useState(name);
  const [error, setError] = useState<unknown>(null);
  const save = (event: Event) => {
    event.preventDefault();
    patch(`api/classes/${id}`, { name: text.trim() }).then(onSaved, setError);
  };
  return (
    <Dialog title={t("renameClass")} onClose={onClose}>
      <form class="rename-class" onSubmit={save}>
        <Field label={t("className")}>
          <input required ref={first} maxLength={120} value={text} onInput={(event) => setText(event.currentTarget.value)} />
        </Field>
        <p class="row">
          <button type="submit" disabled={!text.trim()}>{common("save")}</button>
          <button type="button" class="quiet" onClick={onClose}>{common("cancel")}</button>
        </p>
        {error !== null && <ErrorMessage error={error} />}
      </form>
    </Dialog>
  );
}

function DeleteDialog({ id, name, pupils, tasks, onClose }: ClassInfo & { onClose: () => void }) {
  const first = useFocused<HTMLButtonElement>();
  const [error, setError] = useState<unknown>(null);
  const [sending, setSending] = useState(false);
  const deleteClass = () => {
    setSending(true);
    remove(`api/classes/${id}`).then(
      () => navigate("/classes"),
      (problem: unknown) => (setError(problem), setSending(false)),
    );
  };
  return (
    <Dialog title={t("deleteClassSure", { name })} onClose={onClose}>
      <ul class="what-becomes">
        <li>{t("deleteClassGoes", { pupils, tasks })}</li>
        <li>{t("deleteClassStays")}</li>
        {session.value?.person?.role === "teacher" && <li>{t("deleteClassUnseen")}</li>}
      </ul>
      <p class="row">
        <button type="button" disabled={sending} onClick={deleteClass}>{t("deleteYes")}</button>
        <button type="button" class="quiet" ref={first} disabled={sending} onClick={onClose}>{t("deleteNo")}</button>
      </p>
      {error !== null && <ErrorMessage error={error} />}
    </Dialog>
  );
}

/** Gives an element the focus when its dialog opens; otherwise the close button would get it. */
function useFocused<T extends HTMLElement>() {
  const first = useRef<T>(null);
  useEffect(() => first.current?.focus(), []);
  return first;
}
