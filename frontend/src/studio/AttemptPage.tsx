// One kept attempt: its mark, its writing once more, and the teacher's own mark beside ours.

import { useState } from "preact/hooks";
import { get, put, remove, session } from "../api";
import { say, t } from "../i18n";
import { go, type PageProps } from "../router";
import type { Attempt, TeacherMark } from "../types";
import { Field, PageTrouble, Trouble, useLoaded, Waiting } from "../ui";
import { moment } from "./Curve";
import { MarkView } from "./mark/MarkView";
import { Replay } from "./Replay";
import { w } from "./say";
import { gridName } from "./Tools";
import "./studio.css";

export default function AttemptPage({ params }: PageProps) {
  const id = params["id"] ?? "";
  const who = session.value?.person?.id ?? ""; // asked again once it is known who asks
  const found = useLoaded((signal) => get<Attempt>(`/api/attempts/${id}`, signal), `${id} ${who}`);
  const [error, setError] = useState<unknown>(null);
  if (found.error) return <PageTrouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  const attempt = found.value;
  const person = session.value?.person ?? null;
  const own = person !== null && attempt.person?.id === person.id;
  const drop = () => confirm(w("deleteSure")) && remove(`/api/attempts/${id}`).then(() => go("/practice"), setError);
  return (
    <div class="attempt-page">
      <header class="desk-head">
        <a class="desk-thumb" href={`#/works/${attempt.work.id}`}>
          <img src={attempt.work.thumb} alt={w("seeMaster")} width="72" height="72" />
        </a>
        <div>
          <h1>{say(attempt.work.title)}</h1>
          <p class="note">
            {[attempt.person?.name ?? (attempt.kind === "simulated" ? w("nobody") : ""), moment(attempt.created), w(`kind_${attempt.kind}`), attempt.kind === "pen" && w(gridName(attempt.grid))]
              .filter(Boolean)
              .join(" · ")}
          </p>
          <p class="row">
            <a class="button quiet" href={`#/studio/${attempt.work.id}${attempt.task ? `?task=${attempt.task}` : ""}`}>
              {w("writeAgain")}
            </a>
            {own && (
              <a class="button quiet" href={`#/practice?work=${attempt.work.id}`}>
                {t("practice")}
              </a>
            )}
            {(own || person?.role === "owner") && attempt.kind !== "simulated" && (
              <button type="button" class="quiet" onClick={drop}>
                {w("delete")}
              </button>
            )}
          </p>
          {error !== null && <Trouble error={error} />}
        </div>
      </header>
      <MarkView attempt={attempt} />
      <div class="below">
        <TeacherMarks attempt={attempt} onChange={found.again} />
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
      <h2>{w("teacherMarks")}</h2>
      {attempt.teacher_marks.map((mark, k) => (
        <blockquote key={k}>
          <strong>{mark.mark.toFixed(0)}</strong> {mark.note} <footer class="note">— {mark.teacher}</footer>
        </blockquote>
      ))}
      {teaches && <GiveMark attempt={attempt} given={attempt.teacher_marks.find((mark) => mark.teacher === person.name) ?? null} onChange={onChange} />}
    </section>
  );
}

export function GiveMark({ attempt, given, onChange }: { attempt: { id: string | null }; given: TeacherMark | null; onChange: () => void }) {
  const [mark, setMark] = useState(given ? String(given.mark) : "");
  const [note, setNote] = useState(given?.note ?? "");
  const [state, setState] = useState<"" | "saved" | { error: unknown }>("");
  const save = (event: Event) => {
    event.preventDefault();
    put(`/api/attempts/${attempt.id}/mark`, { mark: Number(mark), note }).then(
      () => (setState("saved"), onChange()),
      (error: unknown) => setState({ error }),
    );
  };
  return (
    <form class="give-mark" onSubmit={save}>
      <Field label={w("yourMark")} hint={w("yourMarkHint")}>
        <input type="number" min="0" max="100" step="any" required value={mark} onInput={(event) => setMark(event.currentTarget.value)} />
      </Field>
      <Field label={w("note")}>
        <textarea rows={2} maxLength={2000} value={note} onInput={(event) => setNote(event.currentTarget.value)} />
      </Field>
      <p class="row">
        <button type="submit">{t("save")}</button>
        <span role="status">{state === "saved" ? w("saved") : ""}</span>
      </p>
      {typeof state === "object" && <Trouble error={state.error} />}
    </form>
  );
}
