import { useEffect, useRef, useState } from "preact/hooks";
import { get, patch } from "../api";
import { t as common, words } from "../i18n";
import { gallery as table } from "../i18n/gallery";
import type { ViewerFacts, Work } from "../types";
import { Dialog, Trouble } from "../ui";
import { changesOf } from "./editing";
import { FactFields } from "./FactFields";
import { forgetList } from "./lastlist";

const t = words(table);

/** `facts`: what the viewer needs, where the change touched it. */
export type Edited = { work: Work; facts: ViewerFacts | null };

/** What an owner changes of what is known of a work. */
export function WorkForm({ work, onClose, onSaved }: { work: Work; onClose: () => void; onSaved: (edited: Edited) => void }) {
  const [error, setError] = useState<unknown>(null);
  const [sending, setSending] = useState(false);
  const button = useRef<HTMLButtonElement>(null);
  useEffect(() => {
    if (error) button.current?.scrollIntoView({ block: "nearest" }); // what is told above it pushed it out of sight
  }, [error]);
  const save = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    setError(null);
    if (!`${form.get("title_zh")}${form.get("title_en")}`.trim()) return setError(new Error(t("titleNeeded")));
    setSending(true);
    try {
      onSaved(await saved(work, form));
    } catch (problem) {
      setError(problem);
      setSending(false);
    }
  };
  return (
    <Dialog title={t("editWork")} onClose={onClose}>
      <form onSubmit={(event) => void save(event)}>
        <FactFields work={work} spacing={work.kind === "image"} />
        {error ? <Trouble error={error} /> : null}
        <button type="submit" ref={button} disabled={sending}>{sending ? t("sending") : common("save")}</button>
      </form>
    </Dialog>
  );
}

async function saved(work: Work, form: FormData): Promise<Edited> {
  const changes = changesOf(work, form);
  if (!Object.keys(changes).length) return { work, facts: null };
  const url = `/api/works/${encodeURIComponent(work.id)}`;
  const changed = await patch<Work>(url, changes);
  forgetList();
  // Another pixel's size is another height and another unit.
  return { work: changed, facts: "spacing" in changes ? await get<ViewerFacts>(`${url}/viewer`) : null };
}
