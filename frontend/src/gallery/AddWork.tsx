import { useEffect, useState } from "preact/hooks";
import { get, post, session } from "../api";
import { say, words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import { go, type PageProps } from "../router";
import type { Facets, Job, Work } from "../types";
import { Field, Trouble, useLoaded } from "../ui";
import { ENDED, JobProgress, useJob } from "./JobProgress";
import { forgetList } from "./lastlist";
import { scriptName } from "./scripts";
import "./gallery.css";
import "./work.css";

const t = words(table);
const WAYS = ["addImage", "addCapture", "addImport"] as const;
type Way = (typeof WAYS)[number];
const PICTURES = "image/jpeg,image/png,image/tiff,image/webp,.tif,.tiff";

export default function AddWork(_: PageProps) {
  const role = session.value?.person?.role;
  const [way, setWay] = useState<Way>("addImage");
  if (role !== "owner" && role !== "teacher") return <p class="trouble">{t("ownersOnly")}</p>;
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
      {way === "addImport" ? <p class="note">{t("importNote")}</p> : <FactFields way={way} />}
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

function FactFields({ way }: { way: Way }) {
  return (
    <>
      <div class="two">
        <Field label={t("titleZh")}><input name="title_zh" lang="zh-Hant" maxLength={200} /></Field>
        <Field label={t("titleEn")}><input name="title_en" lang="en" maxLength={200} /></Field>
        <Field label={t("character")}><input name="character" lang="zh-Hant" maxLength={16} /></Field>
        <Field label={t("script")}>
          <select name="script">
            {["", "seal", "clerical", "regular", "running", "cursive"].map((name) => <option key={name} value={name}>{name ? scriptName(name) : "—"}</option>)}
          </select>
        </Field>
        <Field label={t("handZh")}><input name="hand_zh" lang="zh-Hant" /></Field>
        <Field label={t("handEn")}><input name="hand_en" lang="en" /></Field>
        <Dynasty />
        <Collection />
        <Field label={t("periodZh")}><input name="period_zh" lang="zh-Hant" /></Field>
        <Field label={t("periodEn")}><input name="period_en" lang="en" /></Field>
        <Field label={t("materialZh")}><input name="material_zh" lang="zh-Hant" /></Field>
        <Field label={t("materialEn")}><input name="material_en" lang="en" /></Field>
        <Field label={t("source")} hint={t("sourceHint")}><input name="source" /></Field>
        <Field label={t("licence")} hint={t("licenceHint")}><input name="licence" list="licences" required /></Field>
        <Field label={t("attribution")}><input name="attribution" /></Field>
        {way === "addImage" && (
          <>
            <Field label={t("spacing")} hint={t("spacingHint")}><input name="spacing" type="number" min="0" step="any" /></Field>
            <Field label={t("method")}>
              <select name="method">
                <option value="inflation">{t("inflation")}</option>
                <option value="density">{t("density")}</option>
              </select>
            </Field>
          </>
        )}
      </div>
      <datalist id="licences">{["CC0-1.0", "CC-BY-4.0", "CC-BY-SA-4.0", "public domain", "公有領域"].map((name) => <option key={name} value={name} />)}</datalist>
    </>
  );
}

function Dynasty() {
  const facets = useLoaded((signal) => get<Facets>("/api/facets", signal), "all");
  return (
    <Field label={t("dynasty")}>
      <input name="dynasty" list="dynasties" maxLength={40} />
      <datalist id="dynasties">{(facets.value?.dynasty ?? []).filter((f) => f.value).map((f) => <option key={f.value} value={f.value}>{say(f)}</option>)}</datalist>
    </Field>
  );
}

function Collection() {
  const found = useLoaded((signal) => get<{ id: string; title: { zh: string; en: string } }[]>("/api/collections", signal), "all");
  return (
    <Field label={t("collectionId")}>
      <input name="collection" list="collections" maxLength={100} />
      <datalist id="collections">{(found.value ?? []).map((c) => <option key={c.id} value={say(c.title)} />)}</datalist>
    </Field>
  );
}
