// One class: its tasks, its pupils, and invitations to it.

import { useState } from "preact/hooks";
import { get, post, query, remove, session } from "../api";
import { formatDay, localize } from "../i18n";
import { t as sheets } from "../i18n/sheets";
import { t } from "../i18n/studio";
import { navigate, type PageProps } from "../router";
import type { Page, WorkCard } from "../types";
import { ErrorMessage, ErrorPage, Facts, Field, Loading, useLoaded } from "../ui";
import { InvitationLink } from "../account/InvitationLink";
import { ClassHeader } from "./ClassHeader";
import { type TaskCard, taskTitle } from "./tasks";
import { RequireLogin } from "../account/RequireLogin";

type Pupil = { id: string; name: string };
type SchoolClass = { id: string; name: string; pupils: Pupil[]; tasks: TaskCard[]; invitations: { expires: string }[] };

export default function ClassPage({ params }: PageProps) {
  return (
    <RequireLogin reason={t("classesNeed")}>
      <ClassView id={params["id"] ?? ""} />
    </RequireLogin>
  );
}

function ClassView({ id }: { id: string }) {
  const loaded = useLoaded((signal) => get<SchoolClass>(`api/classes/${id}`, signal), id);
  const teaches = session.value?.person?.role !== "pupil";
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const { name, pupils, tasks, invitations } = loaded.value;
  return (
    <div class="class-page">
      <p class="note">
        <a href="#/classes">← {t("classesTitle")}</a>
      </p>
      {teaches ? <ClassHeader id={id} name={name} pupils={pupils.length} tasks={tasks.length} onChange={loaded.retry} /> : <h1>{name}</h1>}
      <div class="two-columns">
        <section class="panel">
          <h2>{t("tasks")}</h2>
          {tasks.length ? <Tasks tasks={tasks} /> : <p class="note">{t(teaches ? "noTasksTeacher" : "noTasksPupil")}</p>}
          {teaches && <NewTask classId={id} />}
        </section>
        {teaches && (
          <section class="panel">
            <h2>{t("pupils", { count: pupils.length })}</h2>
            <Pupils pupils={pupils} classId={id} onChange={loaded.retry} />
            <p class="note">
              {t("inviteNote")} {invitations.length > 0 && t("openLinks", { count: invitations.length })}
            </p>
            <InvitationLink role="pupil" classId={id} />
            <p class="row class-sheets">
              <a class="button quiet" href={`#/sheets/print${query({ class: id })}`}>{sheets("printSheet")}</a>
              <a class="button quiet" href={`#/sheets${query({ class: id })}`}>{sheets("classPhotos")}</a>
            </p>
          </section>
        )}
      </div>
    </div>
  );
}

function Pupils({ pupils, classId, onChange }: { pupils: Pupil[]; classId: string; onChange: () => void }) {
  const [error, setError] = useState<unknown>(null);
  const takeOut = (pupil: Pupil) =>
    confirm(`${t("takeOutOne", { name: pupil.name })}?`) && remove(`api/classes/${classId}/pupils/${pupil.id}`).then(onChange, setError);
  return (
    <>
      <ul class="pupils">
        {pupils.map((pupil) => (
          <li key={pupil.id} class="row">
            <a class="grow" href={`#/practice?person=${pupil.id}`} aria-label={t("practiceOf", { name: pupil.name })}>
              {pupil.name}
            </a>
            <button type="button" class="quiet small" aria-label={t("takeOutOne", { name: pupil.name })} onClick={() => takeOut(pupil)}>
              {t("takeOut")}
            </button>
          </li>
        ))}
      </ul>
      {error !== null && <ErrorMessage error={error} />}
    </>
  );
}

function Tasks({ tasks }: { tasks: TaskCard[] }) {
  return (
    <ul class="tasks">
      {tasks.map((task) => (
        <li key={task.id}>
          <a class="task-card" href={`#/tasks/${task.id}`}>
            <img src={task.work.thumb} alt="" width="64" height="64" />
            <span>
              <b>{taskTitle(task)}</b>
              <small class="note">
                <Facts items={[localize(task.work.title), task.due && t("due", { day: formatDay(task.due) })]} />
              </small>
            </span>
          </a>
        </li>
      ))}
    </ul>
  );
}

function NewTask({ classId }: { classId: string }) {
  const [master, setMaster] = useState<WorkCard | null>(null);
  const [title, setTitle] = useState("");
  const [note, setNote] = useState("");
  const [due, setDue] = useState("");
  const [error, setError] = useState<unknown>(null);
  const make = (event: Event) => {
    event.preventDefault();
    if (!master) return;
    const until = due ? new Date(`${due}T23:59`).toISOString() : null;
    post<{ id: string }>(`api/classes/${classId}/tasks`, { work: master.id, title: title.trim() || localize(master.title), note, due: until }).then(
      (made) => navigate(`/tasks/${made.id}`),
      setError,
    );
  };
  return (
    <details class="new-task">
      <summary>{t("newTask")}</summary>
      <form onSubmit={make}>
        <PickMaster chosen={master} onChoose={setMaster} />
        <Field label={t("taskTitle")}>
          <input maxLength={200} value={title} placeholder={master ? localize(master.title) : ""} onInput={(event) => setTitle(event.currentTarget.value)} />
        </Field>
        <Field label={t("taskNote")}>
          <textarea rows={2} maxLength={2000} value={note} onInput={(event) => setNote(event.currentTarget.value)} />
        </Field>
        <Field label={t("taskDue")}>
          <input type="date" value={due} onInput={(event) => setDue(event.currentTarget.value)} />
        </Field>
        <button type="submit" disabled={!master}>
          {t("giveTask")}
        </button>
        {error !== null && <ErrorMessage error={error} />}
      </form>
    </details>
  );
}

function PickMaster({ chosen, onChoose }: { chosen: WorkCard | null; onChoose: (work: WorkCard) => void }) {
  const [text, setText] = useState("");
  const url = `api/works${query({ q: text, limit: 24, masters: "true" })}`;
  const loaded = useLoaded((signal) => get<Page<WorkCard>>(url, signal), url);
  return (
    <fieldset class="pick-master">
      <legend>{t("taskMaster")}</legend>
      <input type="search" value={text} placeholder={t("searchHint")} aria-label={t("search")} onInput={(event) => setText(event.currentTarget.value)} />
      <div class="pick-row">
        {(loaded.value?.items ?? []).map((work) => (
          <label key={work.id} title={localize(work.title)}>
            <input type="radio" name="master" class="visually-hidden" checked={chosen?.id === work.id} onChange={() => onChoose(work)} />
            <img src={work.thumb} alt={localize(work.title)} width="64" height="64" loading="lazy" />
          </label>
        ))}
      </div>
      {chosen && <p class="note">{t("chosen", { title: localize(chosen.title) })}</p>}
    </fieldset>
  );
}
