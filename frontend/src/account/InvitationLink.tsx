// A link that lets one person in.

import { useState } from "preact/hooks";
import { post } from "../api";
import { formatDate } from "../i18n";
import { t } from "../i18n/account";
import type { Role } from "../types";
import { ErrorMessage } from "../ui";

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
        {made ? t("another") : t("makeLink")}
      </button>
      {made && (
        <div class="invitation-link">
          <input readOnly value={made.link} aria-label={t("link")} onFocus={(event) => event.currentTarget.select()} />
          <button type="button" class="quiet" onClick={copy}>
            {copied ? t("copied") : t("copyLink")}
          </button>
          <p class="note">{t("linkNote", { until: formatDate(made.expires) })}</p>
        </div>
      )}
      {error !== null && <ErrorMessage error={error} />}
    </div>
  );
}

