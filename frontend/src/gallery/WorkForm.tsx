import { useEffect, useRef, useState } from "preact/hooks";
import { get, patch } from "../api";
import { common } from "../i18n";
import { t } from "../i18n/gallery";
import type { Bilingual, ViewerFacts, Work } from "../types";
import { Dialog, ErrorMessage } from "../ui";
import { FactFields } from "./FactFields";
import { clearLastList } from "./listState";
import { licenceField } from "./licences";

/** `facts`: the viewer's data where the change affects it, else null. */
export type Edited = { work: Work; facts: ViewerFacts | null };

/** The dialog in which an owner edits the metadata of a work. */
export function WorkForm({ work, onClose, onSaved }: { work: Work; onClose: () => void; onSaved: (edited: Edited) => void }) {
  const [error, setError] = useState<unknown>(null);
  const [sending, setSending] = useState(false);
  const button = useRef<HTMLButtonElement>(null);
  useEffect(() => {
    if (error) button.current?.scrollIntoView({ block: "nearest" }); // the message above pushed it out of sight
  }, [error]);
  const save = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    setError(null);
    if (!`${form.get("title_zh")}${form.get("title_en")}`.trim()) return setError(new Error(t("titleNeeded")));
    setSending(true);
    try {
      onSaved(await saveChanges(work, form));
    } catch (problem) {
      setError(problem);
      setSending(false);
    }
  };
  return (
    <Dialog title={t("editWork")} onClose={onClose}>
      <form onSubmit={(event) => void save(event)}>
        <FactFields work={work} spacing={work.kind === "image"} />
        {error ? <ErrorMessage error={error} /> : null}
        <button type="submit" ref={button} disabled={sending}>{sending ? t("sending") : common("save")}</button>
      </form>
    </Dialog>
  );
}

async function saveChanges(work: Work, form: FormData): Promise<Edited> {
  const changes = changesOf(work, form);
  if (!Object.keys(changes).length) return { work, facts: null };
  const url = `api/works/${encodeURIComponent(work.id)}`;
  const changed = await patch<Work>(url, changes);
  clearLastList();
  // The size of a pixel changes the heights and their unit.
  return { work: changed, facts: "spacing" in changes ? await get<ViewerFacts>(`${url}/viewer`) : null };
}

const BILINGUAL_FIELDS = ["title", "hand", "period", "material"] as const;
const PLAIN_FIELDS = ["character", "script", "dynasty", "source", "licence", "attribution"] as const;

type WorkChange = Partial<Record<(typeof BILINGUAL_FIELDS)[number], Bilingual> & Record<(typeof PLAIN_FIELDS)[number], string> & { spacing: number | null }>;

/** Only the fields that differ from the work's are sent, so that two owners do not undo each other's changes. */
export function changesOf(work: Work, form: FormData): WorkChange {
  const formValue = (name: string, before: string) => (form.has(name) ? normalized(String(form.get(name))) : normalized(before));
  const changes: WorkChange = {};
  for (const name of BILINGUAL_FIELDS) {
    const before = work[name];
    const now = { zh: formValue(`${name}_zh`, before.zh), en: formValue(`${name}_en`, before.en) };
    if (now.zh !== normalized(before.zh) || now.en !== normalized(before.en)) changes[name] = now;
  }
  for (const name of PLAIN_FIELDS) {
    const before = name === "licence" ? licenceField(work[name]) : work[name];
    const now = formValue(name, before);
    if (now !== normalized(before)) changes[name] = now;
  }
  if (form.has("spacing")) {
    const spacing = formValue("spacing", "") === "" ? null : Number(form.get("spacing"));
    if (spacing !== work.spacing) changes.spacing = spacing;
  }
  return changes;
}

/** Text with the service's line ends; a browser's form sends others. */
const normalized = (text: string): string => text.replace(/\r\n?/g, "\n").trim();
