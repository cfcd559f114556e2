// Requests to mark a copy. The answer to an earlier request is dropped.

import { useEffect, useRef, useState } from "preact/hooks";
import { post, ServiceError, session } from "../api";
import type { Attempt, Grid } from "../types";

/** framed: the picture was cut out along a printed cell, so that size and place are the writer's. */
export type Copy = { kind: "pen" | "photo"; picture: Blob; strokes?: string; grid: Grid; framed?: boolean };
/** keep: store the copy with its mark. unmarked: store it even if it cannot be marked. */
export type Keeping = { keep: boolean; unmarked: boolean };
export type MarkingState =
  | { state: "none" }
  | { state: "asking" }
  | { state: "done"; attempt: Attempt; copy: Copy; automatic: boolean }
  | { state: "failed"; error: unknown };

export const AUTO_MARK_DELAY_MS = 800; // ms after the last stroke

/** The state of marking, and functions to start and to discard it. automatic: requested automatically; such a mark is not saved. */
export function useMarking(work: string, task: string | null) {
  const [marked, setMarked] = useState<MarkingState>({ state: "none" });
  const turn = useRef(0);
  useEffect(() => () => void turn.current++, []);
  const discard = () => {
    turn.current++;
    setMarked((old) => (old.state === "none" ? old : { state: "none" }));
  };
  const requestMark = async (make: () => Promise<Copy>, options: { automatic: boolean; unmarked?: boolean }) => {
    const mine = ++turn.current;
    setMarked({ state: "asking" });
    try {
      const copy = await make();
      const attempt = await sendCopy(copy, work, task, { keep: !options.automatic && Boolean(session.value?.person), unmarked: options.unmarked ?? false });
      if (mine === turn.current) setMarked({ state: "done", attempt, copy, automatic: options.automatic });
    } catch (error) {
      if (mine === turn.current) setMarked({ state: "failed", error });
    }
  };
  return { marked, requestMark, discard };
}

/** Sends the copy; if its task has been withdrawn meanwhile, sends it without, so that it is not lost. */
async function sendCopy(copy: Copy, work: string, task: string | null, keeping: Keeping): Promise<Attempt> {
  try {
    return await post<Attempt>("api/marks", markForm(copy, work, task, keeping));
  } catch (error) {
    if (!task || !(error instanceof ServiceError) || error.status !== 404) throw error;
    return await post<Attempt>("api/marks", markForm(copy, work, null, keeping));
  }
}

export function markForm(copy: Copy, work: string, task: string | null, { keep, unmarked }: Keeping): FormData {
  const form = new FormData();
  form.set("work", work);
  form.set("kind", copy.kind);
  form.set("picture", copy.picture, copy.picture.type === "image/jpeg" ? "copy.jpg" : "copy.png");
  if (copy.strokes) form.set("strokes", copy.strokes);
  form.set("grid", copy.grid);
  if (task) form.set("task", task);
  if (copy.framed) form.set("framed", "true");
  form.set("keep", String(keep));
  form.set("keep_unmarked", String(unmarked));
  return form;
}
