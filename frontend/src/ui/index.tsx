// The few pieces that every page is made of.

import { cloneElement, isValidElement } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { ServiceError } from "../api";
import { say, t } from "../i18n";

export function Waiting() {
  return (
    <p class="waiting" role="status">
      {t("loading")}
    </p>
  );
}

export function Trouble({ error, again }: { error: unknown; again?: () => void }) {
  const text = error instanceof ServiceError ? say(error.text) : String(error instanceof Error ? error.message : error);
  return (
    <div class="trouble" role="alert">
      <p>{text}</p>
      {again && (
        <button type="button" onClick={again}>
          {t("again")}
        </button>
      )}
    </div>
  );
}

/** What `load` brings, asked again whenever `key` changes; an answer to an older question is dropped. */
export function useLoaded<T>(load: (signal: AbortSignal) => Promise<T>, key: string) {
  const [state, setState] = useState<{ value?: T; error?: unknown; key: string }>({ key: "" });
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const stop = new AbortController();
    load(stop.signal).then(
      (value) => !stop.signal.aborted && setState({ value, key }),
      (error: unknown) => !stop.signal.aborted && setState({ error, key }),
    );
    return () => stop.abort();
  }, [key, turn]);
  return { ...state, fresh: state.key === key, again: () => setTurn((n) => n + 1) };
}

/** The hint describes what is typed into; it is no part of its name. */
export function Field({ label, children, hint }: { label: string; children: ComponentChildren; hint?: string }) {
  const id = useId();
  const described = hint && isValidElement(children) ? cloneElement(children, { "aria-describedby": id }) : children;
  return (
    <div class="field">
      <label>
        <span>{label}</span>
        {described}
      </label>
      {hint && <small id={id}>{hint}</small>}
    </div>
  );
}

export function Dialog({ title, onClose, children }: { title: string; onClose: () => void; children: ComponentChildren }) {
  const box = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    box.current?.showModal();
  }, []);
  return (
    <dialog ref={box} class="dialog" onClose={onClose} aria-label={title}>
      <header>
        <h2>{title}</h2>
        <button type="button" class="quiet" aria-label={t("close")} onClick={() => box.current?.close()}>
          ×
        </button>
      </header>
      {children}
    </dialog>
  );
}
