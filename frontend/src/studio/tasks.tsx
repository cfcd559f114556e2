// A task as its pupils meet it: its title, and which of the copies that were handed in counts.

import { get } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/studio";
import type { Attempt, Bilingual, WorkCard } from "../types";
import { useLoaded } from "../ui";

export type TaskCard = { id: string; title: string; note: string; due: string | null; work: WorkCard };
export type TaskRow = { person: { id: string; name: string }; attempts: number; best: number | null; last: number | null; last_attempt: string | null; teacher_mark: number | null };
export type TaskData = { task: TaskCard & { class_id: string }; rows: TaskRow[]; common: (Bilingual & { kind: string; count: number })[] };

export const taskTitle = (task: TaskCard): string => task.title || localize(task.work.title);

/** The task with this id, or null while it is loading and where there is none that this person may see. */
export function useTask(id: string | null): TaskData | null {
  const loaded = useLoaded((signal) => (id ? get<TaskData>(`api/tasks/${id}`, signal).catch(() => null) : Promise.resolve(null)), id ?? "");
  return loaded.value ?? null;
}

/** Says of a copy whether it is the one that counts for its task: the one that its writer handed in last. */
export function TaskStanding({ attempt }: { attempt: Attempt }) {
  const data = useTask(attempt.task);
  const row = data?.rows.find((one) => one.person.id === attempt.person?.id);
  if (!data || !row) return null;
  return (
    <p class="note">
      {t(row.last_attempt === attempt.id ? "countsYes" : "countsNot", { title: taskTitle(data.task) })} <a href={`#/tasks/${data.task.id}`}>{t("toTask")}</a>
    </p>
  );
}
