// Master and copy as two surfaces under one lamp and one camera.

import { useEffect, useRef, useState } from "preact/hooks";
import { get } from "../../api";
import { localize } from "../../i18n";
import { t } from "../../i18n/studio";
import type { Attempt, ViewerFacts } from "../../types";
import { ErrorMessage } from "../../ui";
import type { Viewer } from "../../viewer/types";

const LAMP = { tilt: 135, slant: 55 };

export function Surfaces({ attempt }: { attempt: Attempt }) {
  const hosts = [useRef<HTMLDivElement>(null), useRef<HTMLDivElement>(null)] as const;
  const viewers = useRef<Viewer[]>([]);
  const [facts, setFacts] = useState<[ViewerFacts, ViewerFacts] | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [lamp, setLamp] = useState(LAMP);
  const [lit, setLit] = useState(true);
  useEffect(() => {
    if (!attempt.id) return;
    let cancelled = false;
    showSurfaces(attempt, hosts.map((host) => host.current), (facts) => cancelled || setFacts(facts)).then(
      (created) => (cancelled ? created.forEach((viewer) => viewer.dispose()) : ((viewers.current = created), setLit(created.every((viewer) => viewer.field !== null)))),
      (reason: unknown) => cancelled || setError(reason),
    );
    return () => {
      cancelled = true;
      viewers.current.forEach((viewer) => viewer.dispose());
      viewers.current = [];
    };
  }, [attempt.id]);
  if (!attempt.id) return <p class="note">{t("surfacesNeedLogin")}</p>;
  if (error) return <ErrorMessage error={error} />;
  const turn = (part: Partial<typeof LAMP>) => {
    const next = { ...lamp, ...part };
    setLamp(next);
    viewers.current.forEach((viewer) => viewer.set(next));
  };
  return (
    <div class="surfaces">
      <div class="surfaces-pair">
        {(["master", "copy"] as const).map((name, k) => (
          <figure key={name}>
            <figcaption>{t(name)}</figcaption>
            <div ref={hosts[k]} class="surface-host" role="img" aria-label={t("surfaceAlt", { name: t(name) })} />
            {facts && <small class="note">{localize(facts[k]!.source_text)}</small>}
          </figure>
        ))}
      </div>
      {lit && <LampSliders lamp={lamp} turn={turn} />}
    </div>
  );
}

function LampSliders({ lamp, turn }: { lamp: typeof LAMP; turn: (part: Partial<typeof LAMP>) => void }) {
  return (
    <>
      <label class="slider">
        <span>{t("lampTilt")}</span>
        <input type="range" min="0" max="360" value={lamp.tilt} onInput={(event) => turn({ tilt: Number(event.currentTarget.value) })} />
        <span>{lamp.tilt}°</span>
      </label>
      <label class="slider">
        <span>{t("lampSlant")}</span>
        <input type="range" min="10" max="85" value={lamp.slant} onInput={(event) => turn({ slant: Number(event.currentTarget.value) })} />
        <span>{lamp.slant}°</span>
      </label>
    </>
  );
}

async function showSurfaces(
  attempt: Attempt, hosts: (HTMLElement | null)[], onFacts: (facts: [ViewerFacts, ViewerFacts]) => void,
): Promise<Viewer[]> {
  const [{ createViewer }, master, copy] = await Promise.all([
    import("../../viewer/viewer"),
    get<ViewerFacts>(`api/works/${encodeURIComponent(attempt.work.id)}/viewer`),
    get<ViewerFacts>(`api/attempts/${attempt.id}/viewer`),
  ]);
  onFacts([master, copy]);
  const created = await Promise.all(
    [master, copy].map((facts, k) => createViewer(hosts[k]!, facts, { mode: "surface", ...LAMP, interactive: true })),
  );
  created[0]!.link(created[1]!);
  return created;
}
