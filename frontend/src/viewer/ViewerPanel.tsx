// The viewer with all its controls: light dial, legend, toolbar, overlay, plotted cross-section, help.

import { useEffect, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { localize } from "../i18n";
import { t } from "../i18n/viewer";
import type { Bilingual, ViewerFacts } from "../types";
import { Dialog, ErrorMessage, Loading } from "../ui";
import { LightDial } from "./LightDial";
import { belongsToFocus, isModified, listenForKeys } from "./keys";
import { Legend, ScaleBar } from "./Legend";
import { type Pins, SheetOverlay } from "./SheetOverlay";
import { SectionPlot } from "./SectionPlot";
import { type Mode, MODES, type ViewState } from "./state";
import { Toolbar } from "./Toolbar";
import type { Downloads, SheetPoint, Tool, Viewer } from "./types";
import { createViewer } from "./viewer";

export type TitledSurface = { facts: ViewerFacts; title: Bilingual };
type PanelProps = {
  surface: TitledSurface;
  initial: ViewState;
  /** A second work beside the first, with the same light and camera. */
  beside?: TitledSurface | null;
  files?: Downloads | null;
  pins?: Omit<Pins, "shown"> | null;
  onState?: (state: ViewState) => void;
  onViewer?: (viewer: Viewer | null) => void;
  /** If given, pins can be set. */
  onPoint?: (point: SheetPoint) => void;
  onPair?: () => void;
  /** Returns a link to the current view. */
  link?: () => string;
  children?: ComponentChildren;
};

export function ViewerPanel(props: PanelProps) {
  const { surface, beside = null, onPoint } = props;
  const box = useRef<HTMLElement>(null);
  const [state, setState] = useState(props.initial);
  const [viewer, setViewer] = useState<Viewer | null>(null);
  const [second, setSecond] = useState<Viewer | null>(null);
  const [, secondChanged] = useState<ViewState | null>(null);
  /** Which of two viewers was used last: cross-section and hints are that one's. */
  const [touched, setTouched] = useState<"first" | "second">("first");
  const [tool, setTool] = useState<Tool>(props.initial.mode === "sheet" ? "light" : "move");
  const [help, setHelp] = useState(false);
  const [pinsShown, setPinsShown] = useState(loadPinsShown);
  const plot = useRef<HTMLDivElement>(null);
  const stages = useRef<HTMLDivElement>(null);
  const { onState, onViewer } = props;
  const pins = props.pins?.items.length ? { ...props.pins, shown: pinsShown } : null;
  const togglePins = () => {
    savePinsShown(!pinsShown);
    setPinsShown(!pinsShown);
  };

  useEffect(() => {
    viewer?.link(second);
    return () => viewer?.link(null);
  }, [viewer, second]);
  useEffect(() => listenForKeys(() => box.current?.querySelector<HTMLElement>(touched === "second" ? ".viewer-stage:last-child .viewer-host" : ".viewer-host") ?? null), [touched]);
  if (viewer) viewer.tool = tool;
  if (second) second.tool = tool === "pin" ? "move" : tool;

  const change = (now: ViewState) => {
    setState(now);
    onState?.(now);
  };
  const setMode = (mode: Mode) => {
    // Between the flat sheet and depth the camera is reset, and dragging gets the usual action of the mode.
    const flat = (name: Mode) => name === "sheet";
    const other = flat(mode) !== flat(state.mode);
    viewer?.animateTo({ mode, ...(other || isOblique(mode) !== isOblique(state.mode) ? { camera: null } : {}) }, 700);
    if (other && (tool === "light" || tool === "move")) setTool(flat(mode) ? "light" : "move");
  };
  const chooseTool = (next: Tool) => {
    setTool(next);
    // a work that is drawn on must be in sight; on a phone the toolbar is below it
    if (next !== "light" && next !== "move") stages.current?.scrollIntoView({ block: "nearest", behavior: prefersStill() ? "auto" : "smooth" });
  };
  const keys = (event: KeyboardEvent) => {
    if (isModified(event) || belongsToFocus(event)) return;
    const mode = MODES[Number(event.key) - 1];
    const tools: Record<string, Tool> = { l: "light", m: "move", c: "section", r: "ruler" };
    const picked = tools[event.key];
    if (event.key === "?") setHelp(true);
    else if (mode) setMode(mode);
    else if (picked) chooseTool(picked);
    else if (event.key === "n" && pins) togglePins();
    else if (event.key === "f") void toggleFull(box.current);
    else return;
    event.preventDefault();
  };
  const onSecond = beside !== null && second !== null && touched === "second";
  const acting = onSecond ? second : viewer;
  const { facts, title } = onSecond ? beside : surface;
  const lines = onSecond ? second.state : state;
  const points = acting?.field && lines.section ? acting.section(lines.section) : null;
  // when a cut is finished, not while it is drawn: scrolling would move the picture under the hand
  const showPlot = () => void setTimeout(() => plot.current?.scrollIntoView({ block: "nearest", behavior: prefersStill() ? "auto" : "smooth" }), PLOT_DELAY_MS);
  const cutting = tool === "section" || points !== null;
  const sign = beside && (points || tool === "section" || tool === "ruler") ? <ActiveSign /> : null;
  return (
    <section class="viewer" ref={box} aria-label={t("viewer")} onKeyDown={keys}>
      <div ref={stages} class={`viewer-stages mode-${state.mode} tool-${tool}${cutting ? " cutting" : ""}`} data-count={beside ? 2 : 1} onPointerUp={() => tool === "section" && showPlot()}>
        <ViewerHost surface={surface} initial={state} onState={change} onPoint={onPoint} onTouch={() => setTouched("first")} sign={!onSecond && sign}
          onViewer={(ready) => { setViewer(ready); onViewer?.(ready); }}>
          {(ready) => (
            <>
              <SheetOverlay viewer={ready} pins={pins} />
              {(state.mode === "heights" || state.mode === "contours") && <Legend viewer={ready} />}
              <ScaleBar viewer={ready} />
              {ready.field && <LightDial state={state} onTurn={(light) => ready.set(light)} />}
              {props.children}
            </>
          )}
        </ViewerHost>
        {beside && (
          <ViewerHost key={beside.facts.heights.url} surface={beside} initial={{ ...state, section: null, ruler: null }} onState={secondChanged}
            onTouch={() => setTouched("second")} sign={onSecond && sign} onViewer={(ready) => { setSecond(ready); if (!ready) setTouched("first"); }} caption>
            {(ready) => <SheetOverlay viewer={ready} pins={null} />}
          </ViewerHost>
        )}
      </div>
      {points && (
        <div class="viewer-profile" ref={plot}>
          {beside && <strong class="profile-of">{localize(title)}</strong>}
          <SectionPlot points={points} unit={facts.unit} note={localize(facts.source_text)} />
          <button type="button" class="quiet" onClick={() => acting?.set({ section: null })}>{t("clearSection")}</button>
        </div>
      )}
      <Toolbar viewer={viewer} state={state} tool={tool} mode={setMode} setTool={chooseTool} pairing={beside !== null} canPin={onPoint !== undefined} pinsShown={pins && pinsShown} togglePins={togglePins}
        files={props.files ?? null} onPair={props.onPair} link={props.link} onHelp={() => setHelp(true)} onFull={() => void toggleFull(box.current)} />
      {tool === "section" && !points && <p class="viewer-hint">{t("drawSection")}</p>}
      {tool === "ruler" && !lines.ruler && <p class="viewer-hint">{t("drawRuler")}</p>}
      {tool === "pin" && <p class="viewer-hint">{t("setPin")}</p>}
      {help && <HelpDialog onClose={() => setHelp(false)} />}
    </section>
  );
}

type ViewerHostProps = {
  surface: TitledSurface;
  initial: ViewState;
  caption?: boolean;
  onState?: (state: ViewState) => void;
  onPoint?: ((point: SheetPoint) => void) | undefined;
  onViewer: (viewer: Viewer | null) => void;
  onTouch: () => void;
  /** If not empty, this viewer of two is the one that cross-section and ruler belong to. */
  sign: ComponentChildren;
  children: (viewer: Viewer) => ComponentChildren;
};

function ViewerHost({ surface, initial, caption, onState, onPoint, onViewer, onTouch, sign, children }: ViewerHostProps) {
  const host = useRef<HTMLDivElement>(null);
  const [viewer, setViewer] = useState<Viewer | null>(null);
  const [error, setError] = useState<unknown>(null);
  const [run, setRun] = useState(0);
  const callbacks = useRef({ onState, onPoint });
  callbacks.current = { onState, onPoint };
  useEffect(() => {
    const controller = new AbortController();
    let created: Viewer | null = null;
    setError(null);
    createViewer(host.current!, surface.facts, {
      ...initial,
      signal: controller.signal,
      onChange: (state) => callbacks.current.onState?.(state),
      onPoint: (point) => callbacks.current.onPoint?.(point),
    }).then(
      (ready) => {
        if (controller.signal.aborted) return ready.dispose();
        created = ready;
        setViewer(ready);
        onViewer(ready);
      },
      (problem: unknown) => !controller.signal.aborted && setError(problem),
    );
    return () => {
      controller.abort();
      setViewer(null);
      onViewer(null);
      created?.dispose();
    };
  }, [surface.facts.heights.url, run]);
  return (
    <div class={sign ? "viewer-stage acting" : "viewer-stage"}>
      <div class="viewer-host" ref={host} onPointerDown={onTouch} onFocusIn={onTouch} role="application" aria-label={`${localize(surface.title)}. ${t("hostLabel")}`} />
      {viewer ? children(viewer) : error ? <ErrorMessage error={error} retry={() => setRun((n) => n + 1)} /> : <div class="viewer-wait"><img src={surface.facts.albedo} alt="" /><Loading /></div>}
      {sign}
      {caption && <p class="viewer-caption">{localize(surface.title)}<small>{localize(surface.facts.source_text)}</small></p>}
    </div>
  );
}

/** Which viewer is active, in words: not everybody can see the frame. */
const ActiveSign = () => (
  <p class="viewer-acting" role="status">
    {t("actingHere")}
  </p>
);

const PLOT_DELAY_MS = 60; // the plot is on the page one frame after the pointer is lifted
const prefersStill = (): boolean => matchMedia("(prefers-reduced-motion: reduce)").matches;

const PINS_KEY = "rumu.pins";
const HIDDEN = "hidden";

function loadPinsShown(): boolean {
  try {
    return localStorage.getItem(PINS_KEY) !== HIDDEN;
  } catch {
    return true; // without storage
  }
}

function savePinsShown(shown: boolean): void {
  try {
    localStorage.setItem(PINS_KEY, shown ? "shown" : HIDDEN);
  } catch {
    // the choice holds until the page is left
  }
}

const isOblique = (mode: Mode): boolean => mode === "surface" || mode === "mesh";

async function toggleFull(box: HTMLElement | null): Promise<void> {
  if (document.fullscreenElement) await document.exitFullscreen();
  else await box?.requestFullscreen?.();
}

const HELP_KEYS: [string, Parameters<typeof t>[0]][] = [
  ["← → ↑ ↓", "keyLight"],
  ["← → ↑ ↓", "keyPan"],
  ["⇧ ← → ↑ ↓", "keyOrbit"],
  ["+ −", "keyZoom"],
  ["0", "keyHome"],
  ["1 – 5", "keyModes"],
  ["L M C R", "keyTools"],
  ["N", "keyPins"],
  ["F", "keyFull"],
  ["?", "keyHelp"],
];
const GESTURES: Parameters<typeof t>[0][] = ["gestureLight", "gestureOrbit", "gesturePinch", "gestureRightButton"];

function HelpDialog({ onClose }: { onClose: () => void }) {
  return (
    <Dialog title={t("help")} onClose={onClose}>
      <p class="note">{t("keysAnywhere")}</p>
      <ul class="gestures">
        {GESTURES.map((name) => (
          <li key={name}>{t(name)}</li>
        ))}
      </ul>
      <table class="keys">
        <tbody>
          {HELP_KEYS.map(([key, name]) => (
            <tr key={name}>
              <th scope="row"><kbd>{key}</kbd></th>
              <td>{t(name)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </Dialog>
  );
}
