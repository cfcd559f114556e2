// A button that makes a link by which one person can join.

import { useState } from "preact/hooks";
import { post } from "../api";
import { formatDate } from "../i18n";
import { t } from "../i18n/account";
import type { Role } from "../types";
import { ErrorMessage } from "../ui";
import "./account.css";

type NewInvitation = { link: string; expires: string };

export function InvitationLink({ role, classId, onCreated }: { role: Role; classId?: string; onCreated?: () => void }) {
  const [created, setCreated] = useState<NewInvitation | null>(null);
  const [copied, setCopied] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const make = () =>
    post<NewInvitation>("api/invitations", { role, ...(classId ? { class_id: classId } : {}) }).then((done) => {
      setCreated({ ...done, link: new URL(done.link, location.origin).href });
      setCopied(false);
      setError(null);
      onCreated?.();
    }, setError);
  const copy = () => created && navigator.clipboard?.writeText(created.link).then(() => setCopied(true), () => undefined);
  return (
    <div class="invitation">
      <button type="button" class={created ? "quiet" : ""} onClick={make}>
        {created ? t("another") : t("makeLink")}
      </button>
      {created && (
        <div class="invitation-link">
          <input readOnly value={created.link} aria-label={t("link")} onFocus={(event) => event.currentTarget.select()} />
          <button type="button" class="quiet" onClick={copy}>
            {copied ? t("copied") : t("copyLink")}
          </button>
          <p class="note">{t("linkNote", { until: formatDate(created.expires) })}</p>
        </div>
      )}
      {error !== null && <ErrorMessage error={error} />}
    </div>
  );
}

