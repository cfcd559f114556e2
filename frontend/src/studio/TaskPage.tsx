// One task: what to write, for a pupil; the class's results and the teacher's own marks, for a teacher.

import { useState } from "preact/hooks";
import { get, query, remove, session } from "../api";
import { formatDay, localize } from "../i18n";
import { t as sheets } from "../i18n/sheets";
import { t } from "../i18n/studio";
import { navigate, type PageProps } from "../router";
import type { Attempt, Page } from "../types";
import { Dialog, ErrorMessage, ErrorPage, Facts, Loading, useLoaded } from "../ui";
import { GiveMark } from "./AttemptPage";
import { AttemptCard, MasterHeader, MasterPicture } from "./cards";
import { type TaskCard, type TaskData, type TaskRow, taskTitle } from "./tasks";
import { RequireLogin } from "../account/RequireLogin";

export default function TaskPage({ params }: PageProps) {
  return (
    <RequireLogin reason={t("classesNeed")}>
      <TaskView id={params["id"] ?? ""} />
    </RequireLogin>
  );
}

function TaskView({ id }: { id: string }) {
  const loaded = useLoaded((signal) => get<TaskData>(`api/tasks/${id}`, signal), id);
  const teaches = session.value?.person?.role !== "pupil";
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const { task } = loaded.value;
  return (
    <div class="task-page">
      <p class="note">
        <a href={`#/classes/${task.class_id}`}>← {t("toClass")}</a>
      </p>
      <MasterHeader work={task.work}>
        <h1>{taskTitle(task)}</h1>
        <p class="note">
          <Facts items={[localize(task.work.title), task.due && t("due", { day: formatDay(task.due) })]} />
        </p>
        {task.note && <p>{task.note}</p>}
        <p class="row">{teaches ? <PrintLink task={task} /> : <WriteLink task={task} />}{teaches && <WithdrawTask task={task} />}</p>
      </MasterHeader>
      {teaches ? <MarksTable data={loaded.value} onChange={loaded.retry} /> : <OwnCopies task={task} />}
    </div>
  );
}

const WriteLink = ({ task }: { task: TaskCard }) => (
  <a class="button" href={`#/studio/${task.work.id}?task=${task.id}`}>
    {t("writeTask")}
  </a>
);

const PrintLink = ({ task }: { task: TaskCard & { class_id: string } }) => (
  <a class="button quiet" href={`#/sheets/print${query({ works: task.work.id, class: task.class_id })}`}>
    {sheets("printTask")}
  </a>
);

function WithdrawTask({ task }: { task: TaskCard & { class_id: string } }) {
  const [error, setError] = useState<unknown>(null);
  const takeBack = () =>
    confirm(t("takeBackSure")) && remove(`api/tasks/${task.id}`).then(() => navigate(`/classes/${task.class_id}`), setError);
  return (
    <>
      <button type="button" class="quiet small" onClick={takeBack}>
        {t("takeBack")}
      </button>
      {error !== null && <ErrorMessage error={error} />}
    </>
  );
}

function MarksTable({ data, onChange }: { data: TaskData; onChange: () => void }) {
  const [marking, setMarking] = useState<TaskRow | null>(null);
  const { task, rows, common } = data;
  return (
    <div class="two-columns wide-first">
      <section class="panel">
        <h2>{t("table")}</h2>
        <div class="scroll" tabIndex={0} role="region" aria-label={t("table")}>
          <table>
            <thead>
              <tr>
                <th scope="col">{t("pupil")}</th>
                <th scope="col" class="number">{t("attempts")}</th>
                <th scope="col" class="number">{t("best")}</th>
                <th scope="col" class="number">{t("last")}</th>
                <th scope="col" class="number">{t("teacherColumn")}</th>
                <th scope="col">
                  <span class="visually-hidden">{t("actions")}</span>
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
                        <a href={`#/attempts/${row.last_attempt}`}>{t("open")}</a>
                        <button type="button" class="quiet small" onClick={() => setMarking(row)} aria-label={t("markOf", { name: row.person.name })}>
                          {t("giveMark")}
                        </button>
                      </span>
                    )}
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
        {!rows.length && <p class="note">{t("noRows")}</p>}
        <p class="row">
          <a class="button quiet" href={`api/tasks/${task.id}/marks.csv`} download="marks.csv">
            marks.csv
          </a>
          <a class="button quiet" href={`api/tasks/${task.id}/marks.zip`} download="marks.zip">
            {t("marksZip")}
          </a>
        </p>
        <p class="note">
          {t("calibrate")} <code>rumu calibrate marks.csv -o mine.json</code>
        </p>
      </section>
      <section class="panel">
        <h2>{t("common")}</h2>
        {common.length ? <CommonRemarks data={data} /> : <p class="note">{t("noCommon")}</p>}
      </section>
      {marking && (
        <Dialog title={t("markOf", { name: marking.person.name })} onClose={() => setMarking(null)}>
          <MarkCopy id={marking.last_attempt!} onChange={onChange} />
        </Dialog>
      )}
    </div>
  );
}

function CommonRemarks({ data }: { data: TaskData }) {
  const pupils = data.rows.filter((row) => row.attempts > 0).length;
  return (
    <ul class="common">
      {data.common.map((one) => (
        <li key={one.kind}>
          <span>{localize(one)}</span>
          <meter min={0} max={Math.max(1, pupils)} value={one.count} aria-label={localize(one)} />
          <span class="number">{t("ofPupils", { count: one.count, pupils })}</span>
        </li>
      ))}
    </ul>
  );
}

function MarkCopy({ id, onChange }: { id: string; onChange: () => void }) {
  const loaded = useLoaded((signal) => get<Attempt>(`api/attempts/${id}`, signal), id);
  if (loaded.error) return <ErrorMessage error={loaded.error} />;
  if (!loaded.value) return <Loading />;
  const attempt = loaded.value;
  const existing = attempt.teacher_marks.find((mark) => mark.teacher === session.value?.person?.name) ?? null;
  return (
    <div class="mark-one">
      <div class="side-by-side">
        <figure>
          <MasterPicture work={attempt.work} alt={t("master")} />
          <figcaption>{t("master")}</figcaption>
        </figure>
        <figure>
          {attempt.picture && <img class="sheet-picture" src={attempt.picture} alt={t("copy")} />}
          <figcaption>{t("copy")}</figcaption>
        </figure>
      </div>
      <GiveMark attempt={attempt} existing={existing} onChange={onChange} />
      <details>
        <summary>{t("ourMark")}</summary>
        <p>
          {attempt.mark.score?.toFixed(0) ?? t("noMark")} {localize(attempt.mark.level_text)}
        </p>
      </details>
    </div>
  );
}

function OwnCopies({ task }: { task: TaskCard }) {
  const url = `api/attempts${query({ task: task.id, person: session.value?.person?.id, limit: 60 })}`;
  const loaded = useLoaded((signal) => get<Page<Attempt>>(url, signal), url);
  if (loaded.error) return <ErrorMessage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  return (
    <section class="panel">
      <h2>{t("allAttempts", { count: loaded.value.total })}</h2>
      <p class="note">{t(loaded.value.total ? "countsLast" : "nothingYet")}</p>
      <ul class="attempts">
        {loaded.value.items.map((attempt, k) => (
          <li key={attempt.id}>
            <AttemptCard attempt={attempt} counts={k === 0} />
          </li>
        ))}
      </ul>
    </section>
  );
}
