// The toolbar below the viewer: what is shown, what dragging does, and downloads.

import { useEffect, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { t } from "../i18n/viewer";
import { Icon, type IconName } from "./Icon";
import { PrintForm } from "./PrintForm";
import { supportedSessions } from "./webxr";
import { DEFAULT_VIEW, type Lens, LENSES, type Look, LOOKS, MAX_EXAGGERATION, type Mode, MODES, type ViewState } from "./state";
import type { Downloads, SessionMode, Tool, Viewer } from "./types";

const LENS_NAMES: Record<Lens, Parameters<typeof t>[0]> = {
  none: "lensNone",
  magnify: "lensMagnify",
  picture: "lensPicture",
  heights: "lensHeights",
  normals: "lensNormals",
};

type Props = {
  viewer: Viewer | null;
  state: ViewState;
  tool: Tool;
  pairing: boolean;
  canPin: boolean;
  /** null: the work has no notes. */
  pinsShown: boolean | null;
  togglePins: () => void;
  mode: (mode: Mode) => void;
  setTool: (tool: Tool) => void;
  files: Downloads | null;
  onPair?: (() => void) | undefined;
  link?: (() => string) | undefined;
  onHelp: () => void;
  onFull: () => void;
};

export function Toolbar({ viewer, state, tool, pairing, canPin, pinsShown, togglePins, mode, setTool, files, onPair, link, onHelp, onFull }: Props) {
  if (viewer && !viewer.field) return <PictureToolbar pairing={pairing} onPair={onPair} viewer={viewer} files={files} />;
  const disabled = !viewer;
  const tools: Tool[] = canPin ? ["light", "move", "section", "ruler", "pin"] : ["light", "move", "section", "ruler"];
  return (
    <div class="tools" role="toolbar" aria-label={t("tools")}>
      <div class="segments modes" role="group" aria-label={t("shownAs")}>
        {MODES.map((name) => (
          <Toggle key={name} icon={name} label={t(name)} on={state.mode === name} disabled={disabled} onClick={() => mode(name)} withText />
        ))}
      </div>
      <div class="segments" role="group" aria-label={t("dragging")}>
        {tools.map((name) => (
          <Toggle key={name} icon={name} label={t(`tool_${name}`)} on={tool === name} disabled={disabled} onClick={() => setTool(name)} />
        ))}
      </div>
      <label class="tool-select" title={t("lens")}>
        <Icon name="lens" />
        <span class="visually-hidden">{t("lens")}</span>
        <select value={state.lens} disabled={disabled} onChange={(event) => viewer?.set({ lens: event.currentTarget.value as Lens })}>
          {LENSES.map((name) => (
            <option key={name} value={name}>{t(LENS_NAMES[name])}</option>
          ))}
        </select>
      </label>
      <label class="tool-select" title={t(`look_${state.look}_note`)}>
        <Icon name="lamp" />
        <span class="visually-hidden">{t("look")}</span>
        <select value={state.look} disabled={disabled} onChange={(event) => viewer?.set({ look: event.currentTarget.value as Look })}>
          {LOOKS.map((name) => (
            <option key={name} value={name}>{t(`look_${name}`)}</option>
          ))}
        </select>
      </label>
      <label class="tool-range">
        <span>{t("exaggeration")}</span>
        <input type="range" min="0" max={MAX_EXAGGERATION} step="0.1" value={state.exaggeration} disabled={disabled}
          onInput={(event) => viewer?.set({ exaggeration: Number(event.currentTarget.value) })} />
        <output>×{state.exaggeration.toFixed(1)}</output>
      </label>
      {viewer?.facts.three_lamps && (
        <Toggle icon="lamps" label={t("mixture")} on={state.mixture} disabled={disabled} onClick={() => viewer.set({ mixture: !state.mixture })} withText />
      )}
      <div class="tools-end">
        <Button icon="home" label={t("reset")} disabled={disabled} onClick={() => viewer?.animateTo({ camera: null }, 500)} />
        {pinsShown !== null && <Toggle icon="notes" label={t(pinsShown ? "hidePins" : "showPins")} on={pinsShown} disabled={disabled} onClick={togglePins} />}
        {onPair && <Toggle icon="pair" label={t("pair")} on={pairing} disabled={disabled} onClick={onPair} />}
        <HeadsetButtons viewer={viewer} />
        {link && <CopyLink link={link} />}
        <Button icon="full" label={t("full")} disabled={disabled} onClick={onFull} />
        <Menu icon="save" label={t("download")}>
          <DownloadList viewer={viewer} files={files} exaggeration={state.exaggeration} />
        </Menu>
        <Button icon="help" label={t("help")} onClick={onHelp} />
      </div>
    </div>
  );
}

/** The toolbar without WebGL2: what works with a picture. */
function PictureToolbar({ viewer, pairing, onPair, files }: Pick<Props, "viewer" | "pairing" | "onPair" | "files">) {
  if (!onPair && !files) return null;
  return (
    <div class="tools" role="toolbar" aria-label={t("tools")}>
      <div class="tools-end">
        {onPair && <Toggle icon="pair" label={t("pair")} on={pairing} onClick={onPair} />}
        <Menu icon="save" label={t("download")}>
          <DownloadList viewer={viewer} files={files} />
        </Menu>
      </div>
    </div>
  );
}

type ButtonProps = { icon: IconName; label: string; disabled?: boolean; onClick: () => void };

function Button({ icon, label, disabled = false, onClick }: ButtonProps) {
  return (
    <button type="button" class="tool" title={label} aria-label={label} disabled={disabled} onClick={onClick}>
      <Icon name={icon} />
    </button>
  );
}

function Toggle({ icon, label, on, disabled = false, onClick, withText = false }: ButtonProps & { on: boolean; withText?: boolean }) {
  return (
    <button type="button" class={withText ? "tool worded" : "tool"} title={label} aria-label={label} aria-pressed={on} disabled={disabled} onClick={onClick}>
      <Icon name={icon} />
      {withText && <span>{label}</span>}
    </button>
  );
}

function CopyLink({ link }: { link: () => string }) {
  const [done, setDone] = useState(false);
  const copy = async () => {
    const text = link();
    await navigator.clipboard?.writeText(text).catch(() => prompt(t("copyLink"), text));
    setDone(true);
    setTimeout(() => setDone(false), 1800);
  };
  return (
    <span class="copy">
      <Button icon="link" label={t("copyLink")} onClick={() => void copy()} />
      <span class="copy-done" role="status">{done ? t("copied") : ""}</span>
    </span>
  );
}

function HeadsetButtons({ viewer }: { viewer: Viewer | null }) {
  const [kinds, setKinds] = useState<SessionMode[]>([]);
  useEffect(() => void supportedSessions().then(setKinds), []);
  if (!viewer || !kinds.length) return null;
  return (
    <>
      {kinds.map((kind) => (
        <button key={kind} type="button" class="tool worded" onClick={() => void viewer.immerse(kind)}>
          <Icon name="headset" />
          <span>{kind === "immersive-vr" ? "VR" : "AR"}</span>
        </button>
      ))}
    </>
  );
}

function Menu({ icon, label, children }: { icon: IconName; label: string; children: ComponentChildren }) {
  const box = useRef<HTMLDetailsElement>(null);
  useEffect(() => {
    const close = (event: Event) => {
      if (box.current?.open && !(event.target instanceof Node && box.current.contains(event.target))) box.current.open = false;
    };
    document.addEventListener("pointerdown", close);
    return () => document.removeEventListener("pointerdown", close);
  }, []);
  const leave = (event: KeyboardEvent) => {
    if (event.key !== "Escape" || !box.current) return;
    box.current.open = false;
    box.current.querySelector("summary")?.focus();
  };
  return (
    <details class="menu" ref={box} onKeyDown={leave} onToggle={() => box.current?.open && placeMenu(box.current)}>
      <summary class="tool" title={label} aria-label={label}>
        <Icon name={icon} />
      </summary>
      <div class="menu-list">{children}</div>
    </details>
  );
}

const MENU_GAP = 8; // CSS pixels between a menu and the edges of the window

/** Opens a menu to the side that has more space, not higher than that, and within the width of the window. */
function placeMenu(menu: HTMLDetailsElement): void {
  const list = menu.querySelector<HTMLElement>(".menu-list");
  if (!list) return;
  const button = menu.getBoundingClientRect();
  const [above, below] = [button.top - 2 * MENU_GAP, innerHeight - button.bottom - 2 * MENU_GAP];
  menu.classList.toggle("down", below > above);
  list.style.maxHeight = `${Math.max(above, below)}px`;
  list.style.translate = "none";
  const { left, right } = list.getBoundingClientRect();
  const width = document.documentElement.clientWidth;
  const shift = left < MENU_GAP ? MENU_GAP - left : Math.min(0, width - MENU_GAP - right);
  list.style.translate = `${shift}px 0`;
}

const FILES = ["picture", "glb", "stl", "ply", "height", "normals16", "manifest", "page"] as const;

type DownloadProps = { viewer: Viewer | null; files: Downloads | null; exaggeration?: number };

function DownloadList({ viewer, files, exaggeration = DEFAULT_VIEW.exaggeration }: DownloadProps) {
  const saveAs = async (made: Promise<Blob>, name: string) => {
    const blob = await made;
    const anchor = document.createElement("a");
    anchor.href = URL.createObjectURL(blob);
    anchor.download = name;
    anchor.click();
    setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000);
  };
  return (
    <>
      {viewer?.field && (
        <>
          <button type="button" onClick={() => void saveAs(viewer.snapshot(), "view.png")}>{t("savePng")}</button>
          <button type="button" onClick={() => void saveAs(viewer.relit(), "sheet.png")}>{t("saveSheet")}</button>
        </>
      )}
      {FILES.filter((name) => files?.[name]).map((name) => name === "stl" ? <PrintForm key={name} url={files?.[name] ?? ""} exaggeration={exaggeration} /> : (
        <a key={name} href={name === "manifest" ? files?.[name] : downloadUrl(files?.[name] ?? "")} target={name === "manifest" ? "_blank" : undefined} rel="noopener"
          download={name === "manifest" ? undefined : ""}>
          {t(`file_${name}`)}
        </a>
      ))}
    </>
  );
}

const downloadUrl = (url: string): string => `${url}${url.includes("?") ? "&" : "?"}download=1`;
