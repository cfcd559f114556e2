import { useEffect, useState } from "preact/hooks";
import { get, post, session } from "../api";
import { say, words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import { go, type PageProps } from "../router";
import type { Job, Work } from "../types";
import { Field, Trouble, useLoaded } from "../ui";
import { FactFields } from "./FactFields";
import { ENDED, JobProgress, useJob } from "./JobProgress";
import { forgetList } from "./lastlist";
import "./gallery.css";
import "./work.css";

const t = words(table);
const WAYS = ["addImage", "addCapture", "addImport"] as const;
type Way = (typeof WAYS)[number];
const PICTURES = "image/jpeg,image/png,image/tiff,image/webp,.tif,.tiff";

export default function AddWork(_: PageProps) {
  const role = session.value?.person?.role;
  const [way, setWay] = useState<Way>("addImage");
  if (role !== "owner" && role !== "teacher") return <div class="trouble"><h1>{t("ownersOnly")}</h1></div>;
  return (
    <div class="add">
      <header class="page-head">
        <h1>{t("add")}</h1>
        <p class="lead">{t("addLead")}</p>
      </header>
      <div class="segments" role="group" aria-label={t("add")}>
        {WAYS.map((name) => (
          <button key={name} type="button" class="tool" aria-pressed={way === name} onClick={() => setWay(name)}>{t(name)}</button>
        ))}
      </div>
      <SendForm key={way} way={way} />
    </div>
  );
}

function SendForm({ way }: { way: Way }) {
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
    form.set(way === "addImage" ? "picture" : "zip", file);
    setSending(true);
    setError(null);
    forgetList();
    try {
      if (way === "addImage") go(`/works/${encodeURIComponent((await post<Work>("/api/works", form)).id)}`);
      else setStarted((await post<{ job: Job }>("/api/imports", form)).job);
    } catch (problem) {
      setError(problem);
    } finally {
      setSending(false);
    }
  };
  return (
    <form onSubmit={(event) => void send(event)}>
      <Drop label={t(way === "addImage" ? "picture" : way === "addCapture" ? "captureZip" : "importZip")} accept={way === "addImage" ? PICTURES : ".zip,application/zip"} file={file} onFile={setFile} />
      {way === "addImport" ? <><p class="note">{t("importNote")}</p><Collection hint={t("importCollectionHint")} /></> : <FactFields spacing={way === "addImage"}>{way === "addImage" && <Method />}<Collection /></FactFields>}
      <button type="submit" disabled={!file || sending || (job !== null && !ENDED.has(job.state))}>{t(sending ? "sending" : "send")}</button>
      {error ? <Trouble error={error} /> : null}
      {job && <JobProgress job={job} />}
    </form>
  );
}

function Drop({ label, accept, file, onFile }: { label: string; accept: string; file: File | null; onFile: (file: File | null) => void }) {
  const [over, setOver] = useState(false);
  const [seen, setSeen] = useState<string | null>(null);
  useEffect(() => {
    if (!file || !/^image\/(jpeg|png|webp)$/.test(file.type)) return setSeen(null);
    const url = URL.createObjectURL(file);
    setSeen(url);
    return () => URL.revokeObjectURL(url);
  }, [file]);
  const hold = (event: DragEvent) => {
    event.preventDefault();
    setOver(event.type === "dragover");
  };
  return (
    <label class={over ? "drop over" : "drop"} onDragOver={hold} onDragLeave={hold}
      onDrop={(event) => { hold(event); onFile(event.dataTransfer?.files[0] ?? null); }}>
      <span>{label}</span>
      <input type="file" accept={accept} onChange={(event) => onFile(event.currentTarget.files?.[0] ?? null)} />
      {seen && <img src={seen} alt="" />}
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

function Collection({ hint = "" }: { hint?: string }) {
  const found = useLoaded((signal) => get<{ id: string; title: { zh: string; en: string } }[]>("/api/collections", signal), "all");
  return (
    <Field label={t("collectionId")} hint={hint}>
      <input name="collection" list="collections" maxLength={100} />
      <datalist id="collections">{(found.value ?? []).map((c) => <option key={c.id} value={say(c.title)} />)}</datalist>
    </Field>
  );
}
