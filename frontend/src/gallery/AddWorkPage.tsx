import { useEffect, useState } from "preact/hooks";
import { get, post, session } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import { t as ofWhole } from "../i18n/whole";
import { navigate, type PageProps } from "../router";
import type { Job, Work } from "../types";
import { ErrorMessage, Field, useLoaded } from "../ui";
import { FactFields } from "./FactFields";
import { FINISHED_STATES, JobProgress, useJob } from "./JobProgress";
import { clearLastList } from "./listState";
import "./gallery.css";
import "./work.css";

const SOURCES = ["addImage", "addPage", "addCapture", "addImport", "addMuseum"] as const;
type Source = (typeof SOURCES)[number];
const isPicture = (source: Source): boolean => source === "addImage" || source === "addPage";
const PICTURES = "image/*,.tif,.tiff,.heic,.heif,.avif,.exr,.mpo";

export default function AddWorkPage(_: PageProps) {
  const role = session.value?.person?.role;
  const [source, setSource] = useState<Source>("addImage");
  if (role !== "owner" && role !== "teacher") return <div class="trouble"><h1>{t("ownersOnly")}</h1></div>;
  return (
    <div class="add">
      <header class="page-head">
        <h1>{t("add")}</h1>
        <p class="lead">{t("addLead")}</p>
      </header>
      <div class="segments" role="group" aria-label={t("add")}>
        {SOURCES.filter((name) => name !== "addMuseum" || role === "owner").map((name) => (
          <button key={name} type="button" class="tool" aria-pressed={source === name} onClick={() => setSource(name)}>{name === "addPage" ? ofWhole("page") : name === "addMuseum" ? ofWhole("museum") : t(name)}</button>
        ))}
      </div>
      {source === "addMuseum" ? <MuseumForm /> : <SendForm key={source} source={source} />}
    </div>
  );
}

/** The address of a manifest, which the service fetches for an owner. */
function MuseumForm() {
  const [started, setStarted] = useState<Job | null>(null);
  const [error, setError] = useState<unknown>(null);
  const job = useJob(started);
  const send = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    setError(null);
    clearLastList();
    try {
      setStarted((await post<{ job: Job }>("api/museums", { url: String(form.get("url")).trim(), collection: String(form.get("collection") ?? "") })).job);
    } catch (problem) {
      setError(problem);
    }
  };
  return (
    <form onSubmit={(event) => void send(event)}>
      <p class="note">{ofWhole("museumNote")}</p>
      <Field label={ofWhole("museumAddress")} hint={ofWhole("museumHint")}><input type="url" name="url" required maxLength={2000} pattern="https?://.+" placeholder="https://" /></Field>
      <CollectionField hint={ofWhole("museumCollectionHint")} />
      <button type="submit" disabled={job !== null && !FINISHED_STATES.has(job.state)}>{ofWhole("fetch")}</button>
      {error ? <ErrorMessage error={error} /> : null}
      {job && <JobProgress job={job} />}
    </form>
  );
}

function SendForm({ source }: { source: Exclude<Source, "addMuseum"> }) {
  const [file, setFile] = useState<File | null>(null);
  const [started, setStarted] = useState<Job | null>(null);
  const [sending, setSending] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const job = useJob(started);
  const send = async (event: SubmitEvent) => {
    event.preventDefault();
    if (!file) return;
    const form = new FormData(event.currentTarget as HTMLFormElement);
    for (const [name, value] of [...form]) if (value === "") form.delete(name);
    form.set(isPicture(source) ? "picture" : "zip", file);
    setSending(true);
    setError(null);
    clearLastList();
    try {
      if (source === "addImage") navigate(`/works/${encodeURIComponent((await post<Work>("api/works", form)).id)}`);
      else setStarted((await post<{ job: Job }>(source === "addPage" ? "api/pages" : "api/imports", form)).job);
    } catch (problem) {
      setError(problem);
    } finally {
      setSending(false);
    }
  };
  return (
    <form onSubmit={(event) => void send(event)}>
      <FileDrop label={source === "addPage" ? ofWhole("pagePicture") : t(source === "addImage" ? "picture" : source === "addCapture" ? "captureZip" : "importZip")} accept={isPicture(source) ? PICTURES : ".zip,application/zip"} file={file} onFile={setFile} />
      {source === "addPage" && <Field label={ofWhole("pageText")} hint={ofWhole("pageTextHint")}><textarea name="text" rows={8} required maxLength={20000} lang="zh-Hant" /></Field>}
      {source === "addImport" ? <><p class="note">{t("importNote")}</p><CollectionField hint={t("importCollectionHint")} /></> : <FactFields spacing={isPicture(source)}>{source === "addImage" && <Method />}{source === "addCapture" && <LampsTold />}<CollectionField /></FactFields>}
      <button type="submit" disabled={!file || sending || (job !== null && !FINISHED_STATES.has(job.state))}>{t(sending ? "sending" : "send")}</button>
      {error ? <ErrorMessage error={error} /> : null}
      {job && <JobProgress job={job} />}
    </form>
  );
}

function FileDrop({ label, accept, file, onFile }: { label: string; accept: string; file: File | null; onFile: (file: File | null) => void }) {
  const [over, setOver] = useState(false);
  const [preview, setPreview] = useState<string | null>(null);
  useEffect(() => {
    if (!file || !/^image\/(jpeg|png|webp)$/.test(file.type)) return setPreview(null);
    const url = URL.createObjectURL(file);
    setPreview(url);
    return () => URL.revokeObjectURL(url);
  }, [file]);
  const trackDrag = (event: DragEvent) => {
    event.preventDefault();
    setOver(event.type === "dragover");
  };
  return (
    <label class={over ? "drop over" : "drop"} onDragOver={trackDrag} onDragLeave={trackDrag}
      onDrop={(event) => { trackDrag(event); onFile(event.dataTransfer?.files[0] ?? null); }}>
      <span>{label}</span>
      <input type="file" accept={accept} onChange={(event) => onFile(event.currentTarget.files?.[0] ?? null)} />
      {preview && <img src={preview} alt="" />}
      {file && <small>{file.name}</small>}
    </label>
  );
}

function Method() {
  return (
    <Field label={t("method")}>
      <select name="method">
        <option value="inflation">{t("inflation")}</option>
        <option value="density">{t("density")}</option>
      </select>
    </Field>
  );
}

/** Photographs of a phone come without a file of lamps; the card in them tells these. */
function LampsTold() {
  return (
    <Field label={t("lampsTold")}>
      <select name="lamps">
        <option value="auto">{t("lampsAuto")}</option>
        <option value="card">{t("lampsCard")}</option>
      </select>
    </Field>
  );
}

function CollectionField({ hint = "" }: { hint?: string }) {
  const loaded = useLoaded((signal) => get<{ id: string; title: { zh: string; en: string } }[]>("api/collections", signal), "all");
  return (
    <Field label={t("collectionId")} hint={hint}>
      <input name="collection" list="collections" maxLength={100} />
      <datalist id="collections">{(loaded.value ?? []).map((c) => <option key={c.id} value={localize(c.title)} />)}</datalist>
    </Field>
  );
}
