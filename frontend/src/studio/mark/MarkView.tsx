// A whole mark: the verdict and what changed, and beside it remarks, overlay and surfaces in tabs.

import { useEffect, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { t } from "../../i18n/studio";
import type { Attempt } from "../../types";
import { Tabs } from "../Tabs";
import { DistanceOverlay } from "./DistanceOverlay";
import { Progress } from "./Progress";
import { Remarks } from "./Remarks";
import { Surfaces } from "./Surfaces";
import { Verdict } from "./Verdict";

const VIEWS = ["remarks", "overlay", "surfaces"] as const;

/** picture: of the copy, if the service has not saved it, as for a visitor. remedy: what can be done about a copy that was refused. */
export function MarkView({ attempt, picture, remedy }: { attempt: Attempt; picture?: Blob | null; remedy?: ComponentChildren }) {
  const [view, setView] = useState<(typeof VIEWS)[number]>("remarks");
  const objectUrl = useObjectUrl(picture ?? null);
  const pictureUrl = objectUrl ?? attempt.picture;
  return (
    <div class="mark-view">
      <div class="mark-side">
        <Verdict attempt={attempt} remedy={remedy} />
        {attempt.progress && <Progress progress={attempt.progress} />}
      </div>
      {attempt.mark.refused ? null : (
        <section class="panel" aria-label={t("views")}>
          <Tabs names={VIEWS} chosen={view} onChoose={setView} label={t("views")} title={(name) => t(name)}>
            {view === "remarks" ? (
              <Remarks praise={attempt.mark.praise ?? null} remarks={attempt.mark.remarks} picture={pictureUrl} work={attempt.work} />
            ) : view === "overlay" ? (
              <DistanceOverlay attempt={attempt} picture={pictureUrl} />
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
