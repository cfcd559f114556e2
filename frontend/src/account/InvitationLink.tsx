// A link that lets one person in.

import { useState } from "preact/hooks";
import { post } from "../api";
import { language } from "../i18n";
import type { Role } from "../types";
import { Trouble } from "../ui";
import { a } from "./say";

type Made = { link: string; expires: string };

export function InvitationLink({ role, classId, onMade }: { role: Role; classId?: string; onMade?: () => void }) {
  const [made, setMade] = useState<Made | null>(null);
  const [copied, setCopied] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const make = () =>
    post<Made>("/api/invitations", { role, ...(classId ? { class_id: classId } : {}) }).then((done) => {
      setMade({ ...done, link: new URL(done.link, location.origin).href });
      setCopied(false);
      setError(null);
      onMade?.();
    }, setError);
  const copy = () => made && navigator.clipboard?.writeText(made.link).then(() => setCopied(true), () => undefined);
  return (
    <div class="invitation">
      <button type="button" class={made ? "quiet" : ""} onClick={make}>
        {made ? a("another") : a("makeLink")}
      </button>
      {made && (
        <div class="invitation-link">
          <input readOnly value={made.link} aria-label={a("link")} onFocus={(event) => event.currentTarget.select()} />
          <button type="button" class="quiet" onClick={copy}>
            {copied ? a("copied") : a("copyLink")}
          </button>
          <p class="note">{a("linkNote", { until: until(made.expires) })}</p>
        </div>
      )}
      {error !== null && <Trouble error={error} />}
    </div>
  );
}

const until = (time: string): string =>
  new Date(time).toLocaleDateString(language.value === "zh" ? "zh-Hant-TW" : "en-GB", { year: "numeric", month: "long", day: "numeric" });
