// Master and copy as two surfaces under one lamp and one camera.

import { useEffect, useRef, useState } from "preact/hooks";
import { get } from "../../api";
import { say } from "../../i18n";
import type { Attempt, ViewerFacts } from "../../types";
import { Trouble } from "../../ui";
import type { Viewer } from "../../viewer";
import { w } from "../say";

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
    let gone = false;
    shown(attempt, hosts.map((host) => host.current), (found) => gone || setFacts(found)).then(
      (made) => (gone ? made.forEach((viewer) => viewer.dispose()) : ((viewers.current = made), setLit(made.every((viewer) => viewer.field !== null)))),
      (why: unknown) => gone || setError(why),
    );
    return () => {
      gone = true;
      viewers.current.forEach((viewer) => viewer.dispose());
      viewers.current = [];
    };
  }, [attempt.id]);
  if (!attempt.id) return <p class="note">{w("surfacesNeedLogin")}</p>;
  if (error) return <Trouble error={error} />;
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
            <figcaption>{w(name)}</figcaption>
            <div ref={hosts[k]} class="surface-host" role="img" aria-label={w("surfaceAlt", { name: w(name) })} />
            {facts && <small class="note">{say(facts[k]!.source_text)}</small>}
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
        <span>{w("lampTilt")}</span>
        <input type="range" min="0" max="360" value={lamp.tilt} onInput={(event) => turn({ tilt: Number(event.currentTarget.value) })} />
        <span>{lamp.tilt}°</span>
      </label>
      <label class="slider">
        <span>{w("lampSlant")}</span>
        <input type="range" min="10" max="85" value={lamp.slant} onInput={(event) => turn({ slant: Number(event.currentTarget.value) })} />
        <span>{lamp.slant}°</span>
      </label>
    </>
  );
}

async function shown(
  attempt: Attempt, hosts: (HTMLElement | null)[], onFacts: (facts: [ViewerFacts, ViewerFacts]) => void,
): Promise<Viewer[]> {
  const [{ createViewer }, master, copy] = await Promise.all([
    import("../../viewer"),
    get<ViewerFacts>(`/api/works/${encodeURIComponent(attempt.work.id)}/viewer`),
    get<ViewerFacts>(`/api/attempts/${attempt.id}/viewer`),
  ]);
  onFacts([master, copy]);
  const made = await Promise.all(
    [master, copy].map((facts, k) => createViewer(hosts[k]!, facts, { mode: "surface", ...LAMP, interactive: true })),
  );
  made[0]!.link(made[1]!);
  return made;
}
