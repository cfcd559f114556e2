// The page to send photographs of sheets: one's own, or many of a class; and those that were sent before.

import { useEffect, useState } from "preact/hooks";
import { RequireLogin } from "../account/RequireLogin";
import { get, post, query as queryOf } from "../api";
import { JobProgress, useJob } from "../gallery/JobProgress";
import { formatDateTime } from "../i18n";
import { t } from "../i18n/sheets";
import { navigate, type PageProps } from "../router";
import type { Job, Page } from "../types";
import { ErrorMessage, Facts, Loading, useLoaded } from "../ui";
import { PickPhoto, PHOTO_TYPES } from "./PickPhoto";
import { sendSheet, type SheetSummary } from "./upload";
import "../studio/studio.css";
import "./sheets.css";

export default function SendPage({ query }: PageProps) {
  const classId = query.get("class") ?? "";
  return (
    <RequireLogin reason={t("photoNeeds")} {...(classId ? { roles: ["teacher", "owner"] } : {})}>
      <div class="send-page">
        {classId ? <SendOfClass classId={classId} /> : <SendOwn />}
        <SentBefore classId={classId} />
      </div>
    </RequireLogin>
  );
}

type Sending = { state: "none" } | { state: "sending" } | { state: "failed"; error: unknown };

function SendOwn() {
  const [sending, setSending] = useState<Sending>({ state: "none" });
  const send = async (file: File) => {
    setSending({ state: "sending" });
    try {
      navigate(`/sheets/${await sendSheet(file)}`);
    } catch (error) {
      setSending({ state: "failed", error });
    }
  };
  return (
    <section>
      <h1>{t("photoTitle")}</h1>
      <p class="lead">{t("photoLead")}</p>
      <p class="row">
        <PickPhoto label={t("takePhoto")} camera onFiles={([file]) => file && void send(file)} />
        <PickPhoto label={t("choosePhoto")} onFiles={([file]) => file && void send(file)} />
        <a href="#/sheets/print">{t("printSheet")}</a>
      </p>
      <p role="status" class="note">{sending.state === "sending" ? t("reading") : ""}</p>
      {sending.state === "sending" && <progress aria-label={t("reading")} />}
      {sending.state === "failed" && (
        <section class="sheet-refused">
          <h2>{t("notRead")}</h2>
          <ErrorMessage error={sending.error} />
        </section>
      )}
    </section>
  );
}

function SendOfClass({ classId }: { classId: string }) {
  const [started, setStarted] = useState<Job | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [sending, setSending] = useState(false);
  const job = useJob(started);
  const send = async (files: File[]) => {
    setError(null);
    setSending(true);
    try {
      const form = new FormData();
      for (const file of files) form.append("photos", file, file.name);
      setStarted((await post<{ job: Job }>(`api/classes/${classId}/sheets`, form)).job);
    } catch (failure) {
      setError(failure);
    } finally {
      setSending(false);
    }
  };
  const upload = job?.state === "done" ? (job.result as { upload?: string }).upload : undefined;
  useEffect(() => {
    if (upload) navigate(`/sheets/${upload}`);
  }, [upload]);
  return (
    <section>
      <p class="note">
        <a href={`#/classes/${classId}`}>← {t("table")}</a>
      </p>
      <h1>{t("classPhotos")}</h1>
      <p class="lead">{t("classLead")}</p>
      <p class="row">
        <PickPhoto label={t("chooseFiles")} many types={`${PHOTO_TYPES},application/pdf,application/zip,.zip,.heic`} onFiles={(files) => files.length && void send(files)} />
        <a href={`#/sheets/print${queryOf({ class: classId })}`}>{t("printSheet")}</a>
      </p>
      <p role="status" class="note">{sending ? t("reading") : ""}</p>
      {error !== null && <ErrorMessage error={error} />}
      {job && <JobProgress job={job} outcome={upload ? <a class="button" href={`#/sheets/${upload}`}>{t("table")}</a> : null} />}
    </section>
  );
}

function SentBefore({ classId }: { classId: string }) {
  const url = `api/sheets${queryOf({ school_class: classId })}`;
  const loaded = useLoaded((signal) => get<Page<SheetSummary>>(url, signal), url);
  if (loaded.error) return <ErrorMessage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  return (
    <section class="panel">
      <h2>{t("sentBefore")}</h2>
      {!loaded.value.items.length && <p class="note">{t("noneSent")}</p>}
      <ul class="sent-sheets">
        {loaded.value.items.map((one) => (
          <li key={one.id}>
            <a href={`#/sheets/${one.id}`}>
              <b lang="zh-Hant">{one.characters.slice(0, 12) || "–"}</b> {formatDateTime(one.created)}
            </a>{" "}
            <small class="note">
              <Facts
                items={[
                  one.photos > 1 && t("photosOf", { n: one.photos }), t("countOf", { cells: one.cells }),
                  one.mean !== null && t("meanOf", { mean: one.mean.toFixed(0) }), one.unread > 0 && t("unreadOf", { n: one.unread }),
                ]}
              />
            </small>
          </li>
        ))}
      </ul>
    </section>
  );
}
