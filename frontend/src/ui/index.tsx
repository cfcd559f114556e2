// The few pieces that every page is made of.

import { cloneElement, isValidElement } from "preact";
import { useEffect, useId, useRef, useState } from "preact/hooks";
import type { ComponentChildren } from "preact";
import { ServiceError } from "../api";
import { common, localize } from "../i18n";

export function Loading() {
  return (
    <p class="waiting" role="status">
      {common("loading")}
    </p>
  );
}

type ErrorProps = { error: unknown; retry?: () => void };

export function ErrorMessage({ error, retry }: ErrorProps) {
  return (
    <div class="trouble" role="alert">
      <p>{reason(error)}</p>
      {retry && (
        <button type="button" onClick={retry}>
          {common("again")}
        </button>
      )}
    </div>
  );
}

/** ErrorMessage in place of a whole page: its reason is the heading, and what is not there is not asked for again. */
export function ErrorPage({ error, retry }: ErrorProps) {
  const missing = error instanceof ServiceError && error.status === 404;
  return (
    <div class="trouble" role="alert">
      <h1>{reason(error)}</h1>
      {retry && !missing ? <button type="button" onClick={retry}>{common("again")}</button> : <p><a href="#/">{common("home")}</a></p>}
    </div>
  );
}

function reason(error: unknown): string {
  return error instanceof ServiceError ? localize(error.text) : String(error instanceof Error ? error.message : error);
}

/** What `load` brings, asked retry whenever `key` changes; an answer to an older question is dropped. */
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
  return { ...state, fresh: state.key === key, retry: () => setTurn((n) => n + 1) };
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

/** Where it is left, by its button or because what was asked is done, the focus goes back to where it came from. */
export function Dialog({ title, onClose, children }: { title: string; onClose: () => void; children: ComponentChildren }) {
  const box = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const before = document.activeElement;
    box.current?.showModal();
    return () => {
      // The browser gives the focus back where a dialogue is closed, but not where it is taken off the page.
      if (document.activeElement === document.body && before instanceof HTMLElement) before.focus();
    };
  }, []);
  return (
    <dialog ref={box} class="dialog" onClose={onClose} aria-label={title}>
      <header>
        <h2>{title}</h2>
        <button type="button" class="quiet" aria-label={common("close")} onClick={() => box.current?.close()}>
          ×
        </button>
      </header>
      {children}
    </dialog>
  );
}
