// The name of a class, which its teacher can change; and the end of a class, which says first what goes and what stays.

import { useEffect, useRef, useState } from "preact/hooks";
import { patch, remove, session } from "../api";
import { t } from "../i18n";
import { go } from "../router";
import { Dialog, Field, Trouble } from "../ui";
import { w } from "./say";

type Head = { id: string; name: string; pupils: number; tasks: number };

/** What a teacher sees above a class. */
export function ClassHead({ onChange, ...head }: Head & { onChange: () => void }) {
  const [doing, setDoing] = useState<"" | "rename" | "delete">("");
  const close = () => setDoing("");
  return (
    <header class="page-head">
      <h1>{head.name}</h1>
      <p class="row">
        <button type="button" class="quiet small" onClick={() => setDoing("rename")}>{w("renameClass")}</button>
        <button type="button" class="quiet small" onClick={() => setDoing("delete")}>{w("deleteClass")}</button>
      </p>
      {doing === "rename" && <Rename {...head} onClose={close} onSaved={() => (close(), onChange())} />}
      {doing === "delete" && <Delete {...head} onClose={close} />}
    </header>
  );
}

function Rename({ id, name, onClose, onSaved }: Head & { onClose: () => void; onSaved: () => void }) {
  const first = useFirst<HTMLInputElement>();
  const [text, setText] = useState(name);
  const [error, setError] = useState<unknown>(null);
  const save = (event: Event) => {
    event.preventDefault();
    patch(`/api/classes/${id}`, { name: text.trim() }).then(onSaved, setError);
  };
  return (
    <Dialog title={w("renameClass")} onClose={onClose}>
      <form class="rename-class" onSubmit={save}>
        <Field label={w("className")}>
          <input required ref={first} maxLength={120} value={text} onInput={(event) => setText(event.currentTarget.value)} />
        </Field>
        <p class="row">
          <button type="submit" disabled={!text.trim()}>{t("save")}</button>
          <button type="button" class="quiet" onClick={onClose}>{t("cancel")}</button>
        </p>
        {error !== null && <Trouble error={error} />}
      </form>
    </Dialog>
  );
}

function Delete({ id, name, pupils, tasks, onClose }: Head & { onClose: () => void }) {
  const first = useFirst<HTMLButtonElement>();
  const [error, setError] = useState<unknown>(null);
  const [sending, setSending] = useState(false);
  const drop = () => {
    setSending(true);
    remove(`/api/classes/${id}`).then(
      () => go("/classes"),
      (problem: unknown) => (setError(problem), setSending(false)),
    );
  };
  return (
    <Dialog title={w("deleteClassSure", { name })} onClose={onClose}>
      <ul class="what-becomes">
        <li>{w("deleteClassGoes", { pupils, tasks })}</li>
        <li>{w("deleteClassStays")}</li>
        {session.value?.person?.role === "teacher" && <li>{w("deleteClassUnseen")}</li>}
      </ul>
      <p class="row">
        <button type="button" disabled={sending} onClick={drop}>{w("deleteYes")}</button>
        <button type="button" class="quiet" ref={first} disabled={sending} onClick={onClose}>{w("deleteNo")}</button>
      </p>
      {error !== null && <Trouble error={error} />}
    </Dialog>
  );
}

/** What has the focus in a dialogue that opens; else it is the button that closes it. */
function useFirst<T extends HTMLElement>() {
  const first = useRef<T>(null);
  useEffect(() => first.current?.focus(), []);
  return first;
}
