import { useEffect, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { post } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { Bilingual, Job } from "../types";
import { messageInOneLanguage } from "./labels";

const NAMES = { queued: "queued", running: "runningJob", done: "doneJob", failed: "failedJob", cancelled: "cancelledJob" } as const;
export const FINISHED_STATES = new Set<Job["state"]>(["done", "failed", "cancelled"]);

/** A job that is updated by server-sent events; the browser reconnects by itself. */
export function useJob(initial: Job | null): Job | null {
  const [job, setJob] = useState(initial);
  useEffect(() => {
    setJob(initial);
    if (!initial || FINISHED_STATES.has(initial.state)) return;
    const events = new EventSource(`api/jobs/${initial.id}/events`);
    events.onmessage = (event: MessageEvent<string>) => {
      const now = JSON.parse(event.data) as Job;
      setJob(now);
      if (FINISHED_STATES.has(now.state)) events.close();
    };
    return () => events.close();
  }, [initial?.id]);
  return job;
}

/** outcome: shown of a job that is done, in place of what an import tells. */
export function JobProgress({ job, outcome }: { job: Job; outcome?: ComponentChildren }) {
  const ended = FINISHED_STATES.has(job.state);
  const box = useRef<HTMLElement>(null);
  useEffect(() => box.current?.scrollIntoView({ block: "nearest", behavior: "smooth" }), [job.id, ended]); // it appears below a long form
  return (
    <section class="panel job" ref={box}>
      <strong role="status">{t(NAMES[job.state])}</strong>{job.total > 0 && <span class="count-of">{job.done.toLocaleString()} / {job.total.toLocaleString()}</span>}
      {job.state === "queued" || (job.state === "running" && !job.total) ? <progress aria-label={t("runningJob")} /> : <progress aria-label={t("runningJob")} value={job.state === "done" ? 1 : job.done} max={job.state === "done" ? 1 : job.total || 1} />}
      {job.message && !ended && <p class="note">{messageInOneLanguage(job.message)}</p>}
      {job.error && <p class="trouble" role="alert">{localize(job.error)}</p>}
      {!ended && <button type="button" class="quiet" onClick={() => void post(`api/jobs/${job.id}/cancel`)}>{t("stop")}</button>}
      {job.state === "done" && (outcome ?? <Outcome result={job.result} />)}
    </section>
  );
}

type Imported = { work?: string; collections?: string[]; added?: number; there?: number; left_out?: [string, string, string][]; left_out_count?: number; assumed?: Bilingual; read_as?: Bilingual | null; notes?: Bilingual[] };

function Outcome({ result }: { result: Imported }) {
  const { work, collections = [], added = 0, there = 0, left_out: skipped = [], left_out_count: skippedCount = 0 } = result;
  return (
    <>
      <p>{t("imported", { added: added.toLocaleString(), there: there.toLocaleString() })}</p>
      {result.read_as && <p class="note">{t("readAs", { how: localize(result.read_as) })}</p>}
      {[...(result.assumed ? [result.assumed] : []), ...(result.notes ?? [])].map((note) => <p class="note" key={note.en}>{localize(note)}</p>)}
      {skippedCount > 0 && (
        <details>
          <summary>{t("leftOut", { n: skippedCount.toLocaleString() })}</summary>
          <ul class="left-out">{skipped.map(([name, en, zh]) => <li key={name}><code>{name}</code> {localize({ zh, en })}</li>)}</ul>
        </details>
      )}
      <p>
        {work ? (
          <a class="button" href={`#/works/${encodeURIComponent(work)}`}>{t("seeIt")}</a>
        ) : (
          <a class="button" href={collections[0] ? `#/gallery?collection=${encodeURIComponent(collections[0])}` : "#/gallery"}>{t("seeAll")}</a>
        )}
      </p>
    </>
  );
}

