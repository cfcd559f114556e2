// Everything of one mark: the verdict, and beside it the copy in three ways.

import { useEffect, useState } from "preact/hooks";
import { t } from "../../i18n/studio";
import type { Attempt } from "../../types";
import { Tabs } from "../Tabs";
import { DistanceOverlay } from "./DistanceOverlay";
import { Remarks } from "./Remarks";
import { Surfaces } from "./Surfaces";
import { Verdict } from "./Verdict";

const VIEWS = ["remarks", "overlay", "surfaces"] as const;

/** picture: of the copy, where the service keeps none: a visitor's. */
export function MarkView({ attempt, picture }: { attempt: Attempt; picture?: Blob | null }) {
  const [view, setView] = useState<(typeof VIEWS)[number]>("remarks");
  const own = useObjectUrl(picture ?? null);
  const shown = own ?? attempt.picture;
  return (
    <div class="mark-view">
      <Verdict attempt={attempt} />
      {attempt.mark.refused ? null : (
        <section class="panel" aria-label={t("views")}>
          <Tabs names={VIEWS} chosen={view} onChoose={setView} label={t("views")} title={(name) => t(name)}>
            {view === "remarks" ? (
              <Remarks remarks={attempt.mark.remarks} picture={shown} />
            ) : view === "overlay" ? (
              <DistanceOverlay attempt={attempt} picture={shown} />
            ) : (
              <Surfaces attempt={attempt} />
            )}
          </Tabs>
        </section>
      )}
    </div>
  );
}

function useObjectUrl(blob: Blob | null): string | null {
  const [url, setUrl] = useState<string | null>(null);
  useEffect(() => {
    if (!blob) return setUrl(null);
    const made = URL.createObjectURL(blob);
    setUrl(made);
    return () => URL.revokeObjectURL(made);
  }, [blob]);
  return url;
}
