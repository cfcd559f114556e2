// How a work is shown elsewhere: a link with a preview, and the code of a frame.

import { useState } from "preact/hooks";
import { t } from "../i18n/gallery";
import { localize } from "../i18n";
import type { Work } from "../types";

export function ShareWork({ work }: { work: Pick<Work, "id" | "title"> }) {
  const name = encodeURIComponent(work.id);
  const title = localize(work.title).replace(/&/g, "&amp;").replace(/"/g, "&quot;");
  return (
    <details class="share">
      <summary>{t("share")}</summary>
      <ShareLink path={`works/${name}`} />
      <CopyField label={t("shareFrame")} text={`<iframe src="${base()}embed/works/${name}" title="${title}" width="640" height="480" allow="fullscreen"></iframe>`} />
    </details>
  );
}

/** The address of the service, with a slash at its end. */
const base = (): string => location.href.split("#")[0]!.replace(/[^/]*$/, "");

/** A link of which messengers make a preview. path: of a work or a collection. */
export const ShareLink = ({ path }: { path: string }) => <CopyField label={t("shareLink")} text={`${base()}share/${path}`} />;

/** A text to be copied: by the button, or selected by hand where a page may not write to the clipboard. */
function CopyField({ label, text }: { label: string; text: string }) {
  const [copied, setCopied] = useState(false);
  const copy = () => navigator.clipboard?.writeText(text).then(() => setCopied(true), () => undefined);
  return (
    <label class="field copy-field">
      <span>{label}</span>
      <span class="row">
        <input class="grow" readOnly value={text} onFocus={(event) => event.currentTarget.select()} />
        <button type="button" class="quiet small" onClick={() => void copy()}>{t(copied ? "copied" : "copy")}</button>
      </span>
    </label>
  );
}
