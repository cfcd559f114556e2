// One class: who learns in it, how they get in, and what they are to write.

import { useState } from "preact/hooks";
import { get, post, query, remove, session } from "../api";
import { say } from "../i18n";
import { go, type PageProps } from "../router";
import type { Page, WorkCard } from "../types";
import { Field, PageTrouble, Trouble, useLoaded, Waiting } from "../ui";
import { InvitationLink } from "../account/InvitationLink";
import { ClassHead } from "./ClassHead";
import { day } from "./Curve";
import { NeedLogin } from "./NeedLogin";
import { w } from "./say";

export type TaskCard = { id: string; title: string; note: string; due: string | null; work: WorkCard };
type Pupil = { id: string; name: string };
type SchoolClass = { id: string; name: string; pupils: Pupil[]; tasks: TaskCard[]; invitations: { expires: string }[] };

export default function ClassPage({ params }: PageProps) {
  return (
    <NeedLogin why={w("classesNeed")}>
      <Shown id={params["id"] ?? ""} />
    </NeedLogin>
  );
}

function Shown({ id }: { id: string }) {
  const found = useLoaded((signal) => get<SchoolClass>(`/api/classes/${id}`, signal), id);
  const teaches = session.value?.person?.role !== "pupil";
  if (found.error) return <PageTrouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  const { name, pupils, tasks, invitations } = found.value;
  return (
    <div class="class-page">
      <p class="note">
        <a href="#/classes">← {w("classesTitle")}</a>
      </p>
      {teaches ? <ClassHead id={id} name={name} pupils={pupils.length} tasks={tasks.length} onChange={found.again} /> : <h1>{name}</h1>}
      <div class="two-columns">
        <section class="panel">
          <h2>{w("tasks")}</h2>
          {tasks.length ? <Tasks tasks={tasks} /> : <p class="note">{w(teaches ? "noTasksTeacher" : "noTasksPupil")}</p>}
          {teaches && <NewTask classId={id} />}
        </section>
        {teaches && (
          <section class="panel">
            <h2>{w("pupils", { count: pupils.length })}</h2>
            <Pupils pupils={pupils} classId={id} onChange={found.again} />
            <p class="note">
              {w("inviteNote")} {invitations.length > 0 && w("openLinks", { count: invitations.length })}
            </p>
            <InvitationLink role="pupil" classId={id} />
          </section>
        )}
      </div>
    </div>
  );
}

function Pupils({ pupils, classId, onChange }: { pupils: Pupil[]; classId: string; onChange: () => void }) {
  const [error, setError] = useState<unknown>(null);
  const takeOut = (pupil: Pupil) =>
    confirm(`${w("takeOutOne", { name: pupil.name })}?`) && remove(`/api/classes/${classId}/pupils/${pupil.id}`).then(onChange, setError);
  return (
    <>
      <ul class="pupils">
        {pupils.map((pupil) => (
          <li key={pupil.id} class="row">
            <a class="grow" href={`#/practice?person=${pupil.id}`} aria-label={w("practiceOf", { name: pupil.name })}>
              {pupil.name}
            </a>
            <button type="button" class="quiet small" aria-label={w("takeOutOne", { name: pupil.name })} onClick={() => takeOut(pupil)}>
              {w("takeOut")}
            </button>
          </li>
        ))}
      </ul>
      {error !== null && <Trouble error={error} />}
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
              <b>{task.title || say(task.work.title)}</b>
              <small class="note">
                {say(task.work.title)}
                {task.due && ` · ${w("due", { day: day(task.due) })}`}
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
    post<{ id: string }>(`/api/classes/${classId}/tasks`, { work: master.id, title: title.trim() || say(master.title), note, due: until }).then(
      (made) => go(`/tasks/${made.id}`),
      setError,
    );
  };
  return (
    <details class="new-task">
      <summary>{w("newTask")}</summary>
      <form onSubmit={make}>
        <PickMaster chosen={master} onChoose={setMaster} />
        <Field label={w("taskTitle")}>
          <input maxLength={200} value={title} placeholder={master ? say(master.title) : ""} onInput={(event) => setTitle(event.currentTarget.value)} />
        </Field>
        <Field label={w("taskNote")}>
          <textarea rows={2} maxLength={2000} value={note} onInput={(event) => setNote(event.currentTarget.value)} />
        </Field>
        <Field label={w("taskDue")}>
          <input type="date" value={due} onInput={(event) => setDue(event.currentTarget.value)} />
        </Field>
        <button type="submit" disabled={!master}>
          {w("giveTask")}
        </button>
        {error !== null && <Trouble error={error} />}
      </form>
    </details>
  );
}

function PickMaster({ chosen, onChoose }: { chosen: WorkCard | null; onChoose: (work: WorkCard) => void }) {
  const [text, setText] = useState("");
  const url = `/api/works${query({ q: text, limit: 24 })}`;
  const found = useLoaded((signal) => get<Page<WorkCard>>(url, signal), url);
  return (
    <fieldset class="pick-master">
      <legend>{w("taskMaster")}</legend>
      <input type="search" value={text} placeholder={w("searchHint")} aria-label={w("search")} onInput={(event) => setText(event.currentTarget.value)} />
      <div class="pick-row">
        {(found.value?.items ?? []).map((work) => (
          <label key={work.id} title={say(work.title)}>
            <input type="radio" name="master" class="visually-hidden" checked={chosen?.id === work.id} onChange={() => onChoose(work)} />
            <img src={work.thumb} alt={say(work.title)} width="64" height="64" loading="lazy" />
          </label>
        ))}
      </div>
      {chosen && <p class="note">{w("chosen", { title: say(chosen.title) })}</p>}
    </fieldset>
  );
}
