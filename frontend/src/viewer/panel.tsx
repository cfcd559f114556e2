// The viewer with everything around it: stages, light, legend, tools, the plotted cut.

import { useEffect, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { say, words } from "../i18n";
import { viewer as table } from "../i18n/viewer";
import type { Text, ViewerFacts } from "../types";
import { Trouble, Waiting } from "../ui";
import { LightDial } from "./dial";
import { KeysHelp } from "./keys";
import { Legend, ScaleBar } from "./legend";
import { Overlay, type Pins } from "./overlay";
import { Profile } from "./profile";
import { MODES, type Mode, type ViewState } from "./state";
import { Tools } from "./tools";
import type { Downloads, Place, Tool, Viewer } from "./types";
import { createViewer } from "./viewer";

const t = words(table);

export type Shown = { facts: ViewerFacts; title: Text };
type PanelProps = {
  shown: Shown;
  initial: ViewState;
  /** A second work beside the first, with the same light and the same eye. */
  beside?: Shown | null;
  files?: Downloads | null;
  pins?: Pins | null;
  onState?: (state: ViewState) => void;
  onViewer?: (viewer: Viewer | null) => void;
  /** Given: the owner may set a pin. */
  onPoint?: (place: Place) => void;
  onPair?: () => void;
  /** A link to the present view. */
  link?: () => string;
  children?: ComponentChildren;
};

export function ViewerPanel(props: PanelProps) {
  const { shown, beside = null, onPoint } = props;
  const box = useRef<HTMLElement>(null);
  const [state, setState] = useState(props.initial);
  const [viewer, setViewer] = useState<Viewer | null>(null);
  const [second, setSecond] = useState<Viewer | null>(null);
  const [, secondChanged] = useState<ViewState | null>(null);
  /** Which of two was touched last: the plotted cut and the hints are that one's. */
  const [touched, setTouched] = useState<"first" | "second">("first");
  const [tool, setTool] = useState<Tool>(props.initial.mode === "sheet" ? "light" : "move");
  const [help, setHelp] = useState(false);
  const { onState, onViewer } = props;

  useEffect(() => {
    viewer?.link(second);
    return () => viewer?.link(null);
  }, [viewer, second]);
  if (viewer) viewer.tool = tool;
  if (second) second.tool = tool === "pin" ? "move" : tool;

  const change = (now: ViewState) => {
    setState(now);
    onState?.(now);
  };
  const setMode = (mode: Mode) => {
    // From the flat sheet to depth and back the eye starts anew, and dragging does what is wanted there.
    const flat = (name: Mode) => name === "sheet";
    const other = flat(mode) !== flat(state.mode);
    viewer?.glide({ mode, ...(other || tilted(mode) !== tilted(state.mode) ? { camera: null } : {}) }, 700);
    if (other && (tool === "light" || tool === "move")) setTool(flat(mode) ? "light" : "move");
  };
  const keys = (event: KeyboardEvent) => {
    if (event.target instanceof HTMLInputElement || event.ctrlKey || event.metaKey || event.altKey) return;
    const mode = MODES[Number(event.key) - 1];
    const tools: Record<string, Tool> = { l: "light", m: "move", c: "section", r: "ruler" };
    const picked = tools[event.key];
    if (event.key === "?") setHelp(true);
    else if (mode) setMode(mode);
    else if (picked) setTool(picked);
    else if (event.key === "f") void toggleFull(box.current);
    else return;
    event.preventDefault();
  };
  const onSecond = beside !== null && second !== null && touched === "second";
  const acting = onSecond ? second : viewer;
  const { facts, title } = onSecond ? beside : shown;
  const lines = onSecond ? second.state : state;
  const points = acting?.field && lines.section ? acting.section(lines.section) : null;
  const sign = beside && (points || tool === "section" || tool === "ruler") ? <ActingSign /> : null;
  return (
    <section class="viewer" ref={box} aria-label={t("viewer")} onKeyDown={keys}>
      <div class={`viewer-stages mode-${state.mode} tool-${tool}`} data-count={beside ? 2 : 1}>
        <Stage shown={shown} initial={state} onState={change} onPoint={onPoint} onTouch={() => setTouched("first")} sign={!onSecond && sign}
          onViewer={(found) => { setViewer(found); onViewer?.(found); }}>
          {(found) => (
            <>
              <Overlay viewer={found} pins={props.pins ?? null} />
              {(state.mode === "heights" || state.mode === "contours") && <Legend viewer={found} />}
              <ScaleBar viewer={found} />
              {found.field && <LightDial state={state} onTurn={(light) => found.set(light)} />}
              {props.children}
            </>
          )}
        </Stage>
        {beside && (
          <Stage key={beside.facts.heights.url} shown={beside} initial={{ ...state, section: null, ruler: null }} onState={secondChanged}
            onTouch={() => setTouched("second")} sign={onSecond && sign} onViewer={(found) => { setSecond(found); if (!found) setTouched("first"); }} caption>
            {(found) => <Overlay viewer={found} pins={null} />}
          </Stage>
        )}
      </div>
      <Tools viewer={viewer} state={state} tool={tool} mode={setMode} setTool={setTool} pairing={beside !== null} canPin={onPoint !== undefined}
        files={props.files ?? null} onPair={props.onPair} link={props.link} onHelp={() => setHelp(true)} onFull={() => void toggleFull(box.current)} />
      {points && (
        <div class="viewer-profile">
          {beside && <strong class="profile-of">{say(title)}</strong>}
          <Profile points={points} unit={facts.unit} note={say(facts.source_text)} />
          <button type="button" class="quiet" onClick={() => acting?.set({ section: null })}>{t("clearSection")}</button>
        </div>
      )}
      {tool === "section" && !points && <p class="viewer-hint">{t("drawSection")}</p>}
      {tool === "ruler" && !lines.ruler && <p class="viewer-hint">{t("drawRuler")}</p>}
      {tool === "pin" && <p class="viewer-hint">{t("setPin")}</p>}
      {help && <KeysHelp onClose={() => setHelp(false)} />}
    </section>
  );
}

type StageProps = {
  shown: Shown;
  initial: ViewState;
  caption?: boolean;
  onState?: (state: ViewState) => void;
  onPoint?: ((place: Place) => void) | undefined;
  onViewer: (viewer: Viewer | null) => void;
  onTouch: () => void;
  /** Given: this one of two is where cut and ruler are. */
  sign: ComponentChildren;
  children: (viewer: Viewer) => ComponentChildren;
};

function Stage({ shown, initial, caption, onState, onPoint, onViewer, onTouch, sign, children }: StageProps) {
  const host = useRef<HTMLDivElement>(null);
  const [viewer, setViewer] = useState<Viewer | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [turn, setTurn] = useState(0);
  const heard = useRef({ onState, onPoint });
  heard.current = { onState, onPoint };
  useEffect(() => {
    const stop = new AbortController();
    let made: Viewer | null = null;
    setError(null);
    createViewer(host.current!, shown.facts, {
      ...initial,
      signal: stop.signal,
      onChange: (state) => heard.current.onState?.(state),
      onPoint: (place) => heard.current.onPoint?.(place),
    }).then(
      (found) => {
        if (stop.signal.aborted) return found.dispose();
        made = found;
        setViewer(found);
        onViewer(found);
      },
      (problem: unknown) => !stop.signal.aborted && setError(problem),
    );
    return () => {
      stop.abort();
      setViewer(null);
      onViewer(null);
      made?.dispose();
    };
  }, [shown.facts.heights.url, turn]);
  return (
    <div class={sign ? "viewer-stage acting" : "viewer-stage"}>
      <div class="viewer-host" ref={host} onPointerDown={onTouch} onFocusIn={onTouch} role="application" aria-label={`${say(shown.title)}. ${t("hostSaid")}`} />
      {viewer ? children(viewer) : error ? <Trouble error={error} again={() => setTurn((n) => n + 1)} /> : <div class="viewer-wait"><img src={shown.facts.picture} alt="" /><Waiting /></div>}
      {sign}
      {caption && <p class="viewer-caption">{say(shown.title)}<small>{say(shown.facts.source_text)}</small></p>}
    </div>
  );
}

/** Says it in words, too: a frame alone is not heard, nor seen by everybody. */
const ActingSign = () => (
  <p class="viewer-acting" role="status">
    {t("actingHere")}
  </p>
);

const tilted = (mode: Mode): boolean => mode === "surface" || mode === "mesh";

async function toggleFull(box: HTMLElement | null): Promise<void> {
  if (document.fullscreenElement) await document.exitFullscreen();
  else await box?.requestFullscreen?.();
}
