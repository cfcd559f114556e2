// One task: to a pupil what to write, to a teacher how it went, with their own marks beside ours.

import { useState } from "preact/hooks";
import { get, query, remove, session } from "../api";
import { say } from "../i18n";
import { go, type PageProps } from "../router";
import type { Attempt, Page, Text } from "../types";
import { Dialog, PageTrouble, Trouble, useLoaded, Waiting } from "../ui";
import { GiveMark } from "./AttemptPage";
import { AttemptCard } from "./AttemptCard";
import type { TaskCard } from "./ClassPage";
import { day } from "./Curve";
import { MasterPicture } from "./MasterPicture";
import { NeedLogin } from "./NeedLogin";
import { w } from "./say";

type Row = { person: { id: string; name: string }; attempts: number; best: number | null; last: number | null; last_attempt: string | null; teacher_mark: number | null };
type Told = { task: TaskCard & { class_id: string }; rows: Row[]; common: (Text & { kind: string; count: number })[] };

export default function TaskPage({ params }: PageProps) {
  return (
    <NeedLogin why={w("classesNeed")}>
      <Shown id={params["id"] ?? ""} />
    </NeedLogin>
  );
}

function Shown({ id }: { id: string }) {
  const found = useLoaded((signal) => get<Told>(`/api/tasks/${id}`, signal), id);
  const teaches = session.value?.person?.role !== "pupil";
  if (found.error) return <PageTrouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  const { task } = found.value;
  return (
    <div class="task-page">
      <p class="note">
        <a href={`#/classes/${task.class_id}`}>← {w("toClass")}</a>
      </p>
      <header class="desk-head">
        <a class="desk-thumb" href={`#/works/${task.work.id}`}>
          <img src={task.work.thumb} alt={w("seeMaster")} width="72" height="72" />
        </a>
        <div>
          <h1>{task.title || say(task.work.title)}</h1>
          <p class="note">
            {say(task.work.title)}
            {task.due && ` · ${w("due", { day: day(task.due) })}`}
          </p>
          {task.note && <p>{task.note}</p>}
          <p class="row">{teaches ? <TakeBack task={task} /> : <WriteIt task={task} />}</p>
        </div>
      </header>
      {teaches ? <Table told={found.value} onChange={found.again} /> : <OwnCopies task={task} />}
    </div>
  );
}

const WriteIt = ({ task }: { task: TaskCard }) => (
  <a class="button" href={`#/studio/${task.work.id}?task=${task.id}`}>
    {w("writeTask")}
  </a>
);

function TakeBack({ task }: { task: TaskCard & { class_id: string } }) {
  const [error, setError] = useState<unknown>(null);
  const takeBack = () =>
    confirm(w("takeBackSure")) && remove(`/api/tasks/${task.id}`).then(() => go(`/classes/${task.class_id}`), setError);
  return (
    <>
      <button type="button" class="quiet small" onClick={takeBack}>
        {w("takeBack")}
      </button>
      {error !== null && <Trouble error={error} />}
    </>
  );
}

function Table({ told, onChange }: { told: Told; onChange: () => void }) {
  const [marking, setMarking] = useState<Row | null>(null);
  const { task, rows, common } = told;
  return (
    <div class="two-columns wide-first">
      <section class="panel">
        <h2>{w("table")}</h2>
        <div class="scroll" tabIndex={0} role="region" aria-label={w("table")}>
          <table>
            <thead>
              <tr>
                <th scope="col">{w("pupil")}</th>
                <th scope="col" class="number">{w("attempts")}</th>
                <th scope="col" class="number">{w("best")}</th>
                <th scope="col" class="number">{w("last")}</th>
                <th scope="col" class="number">{w("teacherColumn")}</th>
                <th scope="col">
                  <span class="visually-hidden">{w("actions")}</span>
                </th>
              </tr>
            </thead>
            <tbody>
              {rows.map((row) => (
                <tr key={row.person.id}>
                  <th scope="row">{row.person.name}</th>
                  <td class="number">{row.attempts}</td>
                  <td class="number">{row.best?.toFixed(0) ?? "–"}</td>
                  <td class="number">{row.last?.toFixed(0) ?? "–"}</td>
                  <td class="number">{row.teacher_mark?.toFixed(0) ?? "–"}</td>
                  <td>
                    {row.last_attempt && (
                      <span class="row">
                        <a href={`#/attempts/${row.last_attempt}`}>{w("open")}</a>
                        <button type="button" class="quiet small" onClick={() => setMarking(row)} aria-label={w("markOf", { name: row.person.name })}>
                          {w("giveMark")}
                        </button>
                      </span>
                    )}
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
        {!rows.length && <p class="note">{w("noRows")}</p>}
        <p class="row">
          <a class="button quiet" href={`/api/tasks/${task.id}/marks.csv`} download="marks.csv">
            marks.csv
          </a>
          <a class="button quiet" href={`/api/tasks/${task.id}/marks.zip`} download="marks.zip">
            {w("marksZip")}
          </a>
        </p>
        <p class="note">
          {w("calibrate")} <code>rumu calibrate marks.csv -o mine.json</code>
        </p>
      </section>
      <section class="panel">
        <h2>{w("common")}</h2>
        {common.length ? <Common told={told} /> : <p class="note">{w("noCommon")}</p>}
      </section>
      {marking && (
        <Dialog title={w("markOf", { name: marking.person.name })} onClose={() => setMarking(null)}>
          <MarkOne id={marking.last_attempt!} onChange={onChange} />
        </Dialog>
      )}
    </div>
  );
}

function Common({ told }: { told: Told }) {
  const pupils = told.rows.filter((row) => row.attempts > 0).length;
  return (
    <ul class="common">
      {told.common.map((one) => (
        <li key={one.kind}>
          <span>{say(one)}</span>
          <meter min={0} max={Math.max(1, pupils)} value={one.count} aria-label={say(one)} />
          <span class="number">{w("ofPupils", { count: one.count, pupils })}</span>
        </li>
      ))}
    </ul>
  );
}

function MarkOne({ id, onChange }: { id: string; onChange: () => void }) {
  const found = useLoaded((signal) => get<Attempt>(`/api/attempts/${id}`, signal), id);
  if (found.error) return <Trouble error={found.error} />;
  if (!found.value) return <Waiting />;
  const attempt = found.value;
  const given = attempt.teacher_marks.find((mark) => mark.teacher === session.value?.person?.name) ?? null;
  return (
    <div class="mark-one">
      <div class="side-by-side">
        <figure>
          <MasterPicture work={attempt.work} alt={w("master")} />
          <figcaption>{w("master")}</figcaption>
        </figure>
        <figure>
          {attempt.picture && <img class="sheet-picture" src={attempt.picture} alt={w("copy")} />}
          <figcaption>{w("copy")}</figcaption>
        </figure>
      </div>
      <GiveMark attempt={attempt} given={given} onChange={onChange} />
      <details>
        <summary>{w("ourMark")}</summary>
        <p>
          {attempt.mark.score?.toFixed(0) ?? w("noMark")} {say(attempt.mark.level_text)}
        </p>
      </details>
    </div>
  );
}

function OwnCopies({ task }: { task: TaskCard }) {
  const url = `/api/attempts${query({ task: task.id, person: session.value?.person?.id, limit: 60 })}`;
  const found = useLoaded((signal) => get<Page<Attempt>>(url, signal), url);
  if (found.error) return <Trouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  return (
    <section class="panel">
      <h2>{w("allAttempts", { count: found.value.total })}</h2>
      {!found.value.total && <p class="note">{w("nothingYet")}</p>}
      <ul class="attempts">
        {found.value.items.map((attempt) => (
          <li key={attempt.id}>
            <AttemptCard attempt={attempt} />
          </li>
        ))}
      </ul>
    </section>
  );
}
