// Says that a photograph is of a whole practice sheet, and reads all of its cells.

import { useState } from "preact/hooks";
import { session } from "../api";
import { loginLink } from "../account/RequireLogin";
import { common } from "../i18n";
import { t } from "../i18n/sheets";
import { navigate } from "../router";
import { ErrorMessage } from "../ui";
import { sendSheet } from "./upload";

/** file: the photograph as it was chosen, in full. */
export function SheetFound({ file }: { file: File | null }) {
  const [reading, setReading] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const read = async () => {
    if (!file) return;
    setReading(true);
    setError(null);
    try {
      navigate(`/sheets/${await sendSheet(file)}`);
    } catch (failure) {
      setError(failure);
    } finally {
      setReading(false);
    }
  };
  return (
    <section class="sheet-found panel">
      <p role="status">{t("isSheet")}</p>
      {session.value?.person ? (
        <button type="button" disabled={reading} onClick={() => void read()}>{t(reading ? "reading" : "readCells")}</button>
      ) : (
        <p>
          {t("photoNeeds")} <a href={loginLink()}>{common("login")}</a>
        </p>
      )}
      {error !== null && <ErrorMessage error={error} />}
    </section>
  );
}
