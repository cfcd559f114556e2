// One saved attempt: its mark, a replay of its strokes, and the teacher's own mark.

import { useState } from "preact/hooks";
import { get, put, remove, session } from "../api";
import { common, formatDateTime, localize } from "../i18n";
import { t } from "../i18n/studio";
import { navigate, type PageProps } from "../router";
import type { Attempt, TeacherMark } from "../types";
import { ErrorMessage, ErrorPage, Facts, Field, Loading, useLoaded } from "../ui";
import { MasterHeader } from "./cards";
import { MarkView } from "./mark/MarkView";
import { Replay } from "./Replay";
import { TaskStanding } from "./tasks";
import { gridName } from "./grids";
import "./studio.css";

export default function AttemptPage({ params }: PageProps) {
  const id = params["id"] ?? "";
  const viewer = session.value?.person?.id ?? ""; // loaded again once it is known who is logged in
  const loaded = useLoaded((signal) => get<Attempt>(`api/attempts/${id}`, signal), `${id} ${viewer}`);
  const [error, setError] = useState<unknown>(null);
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  const attempt = loaded.value;
  const person = session.value?.person ?? null;
  const isOwn = person !== null && attempt.person?.id === person.id;
  const deleteAttempt = () => confirm(t("deleteSure")) && remove(`api/attempts/${id}`).then(() => navigate("/practice"), setError);
  return (
    <div class="attempt-page">
      <MasterHeader work={attempt.work}>
        <h1>{localize(attempt.work.title)}</h1>
        <p class="note">
          <Facts items={[attempt.person?.name ?? (attempt.kind === "simulated" && t("nobody")), formatDateTime(attempt.created), t(`kind_${attempt.kind}`), attempt.kind === "pen" && t(gridName(attempt.grid))]} />
        </p>
        <TaskStanding attempt={attempt} />
        <p class="row">
          <a class="button quiet" href={`#/studio/${attempt.work.id}${attempt.task ? `?task=${attempt.task}` : ""}`}>
            {t("writeAgain")}
          </a>
          {isOwn && (
            <a class="button quiet" href={`#/practice?work=${attempt.work.id}`}>
              {common("practice")}
            </a>
          )}
          {(isOwn || person?.role === "owner") && attempt.kind !== "simulated" && (
            <button type="button" class="quiet" onClick={deleteAttempt}>
              {t("delete")}
            </button>
          )}
        </p>
        {error !== null && <ErrorMessage error={error} />}
      </MasterHeader>
      <MarkView attempt={attempt} />
      <div class="below">
        <TeacherMarks attempt={attempt} onChange={loaded.retry} />
        {attempt.kind === "pen" && <Replay attempt={attempt} />}
      </div>
    </div>
  );
}

function TeacherMarks({ attempt, onChange }: { attempt: Attempt; onChange: () => void }) {
  const person = session.value?.person ?? null;
  const teaches = person !== null && person.role !== "pupil" && attempt.kind !== "simulated";
  if (!teaches && !attempt.teacher_marks.length) return null;
  return (
    <section class="panel teacher-marks">
      <h2>{t("teacherMarks")}</h2>
      {attempt.teacher_marks.map((mark, k) => (
        <blockquote key={k}>
          <strong>{mark.mark.toFixed(0)}</strong> {mark.note} <footer class="note">— {mark.teacher}</footer>
        </blockquote>
      ))}
      {teaches && <GiveMark attempt={attempt} existing={attempt.teacher_marks.find((mark) => mark.teacher === person.name) ?? null} onChange={onChange} />}
    </section>
  );
}

export function GiveMark({ attempt, existing, onChange }: { attempt: { id: string | null }; existing: TeacherMark | null; onChange: () => void }) {
  const [mark, setMark] = useState(existing ? String(existing.mark) : "");
  const [note, setNote] = useState(existing?.note ?? "");
  const [state, setState] = useState<"" | "saved" | { error: unknown }>("");
  const save = (event: Event) => {
    event.preventDefault();
    put(`api/attempts/${attempt.id}/mark`, { mark: Number(mark), note }).then(
      () => (setState("saved"), onChange()),
      (error: unknown) => setState({ error }),
    );
  };
  return (
    <form class="give-mark" onSubmit={save}>
      <Field label={t("yourMark")} hint={t("yourMarkHint")}>
        <input type="number" min="0" max="100" step="any" required value={mark} onInput={(event) => setMark(event.currentTarget.value)} />
      </Field>
      <Field label={t("note")}>
        <textarea rows={2} maxLength={2000} value={note} onInput={(event) => setNote(event.currentTarget.value)} />
      </Field>
      <p class="row">
        <button type="submit">{common("save")}</button>
        <span role="status">{state === "saved" ? t("saved") : ""}</span>
      </p>
      {typeof state === "object" && <ErrorMessage error={state.error} />}
    </form>
  );
}
