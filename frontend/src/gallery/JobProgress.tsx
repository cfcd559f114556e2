import { useEffect, useState } from "preact/hooks";
import { post } from "../api";
import { words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import type { Job } from "../types";

const t = words(table);
const NAMES = { queued: "queued", running: "runningJob", done: "doneJob", failed: "failedJob", cancelled: "cancelledJob" } as const;
const ENDED = new Set<Job["state"]>(["done", "failed", "cancelled"]);

/** What a job says of itself, as it goes: server-sent events, which the browser takes up again by itself. */
export function useJob(given: Job | null): Job | null {
  const [job, setJob] = useState(given);
  useEffect(() => {
    setJob(given);
    if (!given || ENDED.has(given.state)) return;
    const events = new EventSource(`/api/jobs/${given.id}/events`);
    events.onmessage = (event: MessageEvent<string>) => {
      const now = JSON.parse(event.data) as Job;
      setJob(now);
      if (ENDED.has(now.state)) events.close();
    };
    return () => events.close();
  }, [given?.id]);
  return job;
}

export function JobProgress({ job }: { job: Job }) {
  const ended = ENDED.has(job.state);
  return (
    <section class="panel job" aria-live="polite">
      <strong>{t(NAMES[job.state])}{job.total > 0 && ` · ${job.done} / ${job.total}`}</strong>
      {job.state === "queued" || (job.state === "running" && !job.total) ? <progress /> : <progress value={job.state === "done" ? 1 : job.done} max={job.state === "done" ? 1 : job.total || 1} />}
      {job.message && <p class="note">{job.message}</p>}
      {job.error && <p class="trouble">{job.error}</p>}
      {!ended && <button type="button" class="quiet" onClick={() => void post(`/api/jobs/${job.id}/cancel`)}>{t("stop")}</button>}
      {job.state === "done" && <Outcome result={job.result} />}
    </section>
  );
}

function Outcome({ result }: { result: Record<string, unknown> }) {
  const { work, collection } = result;
  const counted = Object.entries(result).filter(([, value]) => typeof value === "number");
  return (
    <p>
      {counted.map(([name, value]) => `${name} ${String(value)}`).join(" · ")}{" "}
      {typeof work === "string" ? (
        <a class="button" href={`#/works/${encodeURIComponent(work)}`}>{t("seeIt")}</a>
      ) : (
        <a class="button" href={typeof collection === "string" ? `#/?collection=${encodeURIComponent(collection)}` : "#/"}>{t("seeAll")}</a>
      )}
    </p>
  );
}
