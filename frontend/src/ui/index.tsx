// Components and hooks that all pages use.

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

/** An error in place of a whole page: the reason is the heading. A page that does not exist offers no retry. */
export function ErrorPage({ error, retry }: ErrorProps) {
  const missing = error instanceof ServiceError && error.status === 404;
  return (
    <div class="trouble" role="alert">
      <h1>{reason(error)}</h1>
      {retry && !missing ? <button type="button" onClick={retry}>{common("again")}</button> : <p><a href="#/gallery">{common("home")}</a></p>}
    </div>
  );
}

function reason(error: unknown): string {
  return error instanceof ServiceError ? localize(error.text) : String(error instanceof Error ? error.message : error);
}

/** The result of `load`, which runs again whenever `key` changes; the results of earlier runs are dropped. */
export function useLoaded<T>(load: (signal: AbortSignal) => Promise<T>, key: string) {
  const [state, setState] = useState<{ value?: T; error?: unknown; key: string }>({ key: "" });
  const [run, setRun] = useState(0);
  useEffect(() => {
    const controller = new AbortController();
    load(controller.signal).then(
      (value) => !controller.signal.aborted && setState({ value, key }),
      (error: unknown) => !controller.signal.aborted && setState({ error, key }),
    );
    return () => controller.abort();
  }, [key, run]);
  return { ...state, fresh: state.key === key, retry: () => setRun((n) => n + 1) };
}

/** A value as it was `ms` ago, or since when it has not changed: while somebody types, nothing is loaded for each letter. */
export function useDelayed<T>(value: T, ms: number): T {
  const [rested, setRested] = useState(value);
  useEffect(() => {
    const timer = setTimeout(() => setRested(value), ms);
    return () => clearTimeout(timer);
  }, [value]);
  return rested;
}

/** The size of an element in pixels of the page; 0 before it is shown. */
export function useSize(): [(element: Element | null) => void, { width: number; height: number }] {
  const [element, setElement] = useState<Element | null>(null);
  const [size, setSize] = useState({ width: 0, height: 0 });
  useEffect(() => {
    if (!element) return;
    const measure = () => setSize({ width: element.clientWidth, height: element.clientHeight });
    measure();
    const observer = new ResizeObserver(measure);
    observer.observe(element);
    return () => observer.disconnect();
  }, [element]);
  return [setElement, size];
}

/** Facts in a row with dots between them; those that are empty or false are left out, with their dots. */
export function Facts({ items }: { items: readonly ComponentChildren[] }) {
  const there = items.filter((item) => item !== null && item !== undefined && typeof item !== "boolean" && !(typeof item === "string" && !item.trim()));
  return <>{there.map((item, k) => (k ? [" · ", item] : item))}</>;
}

/** A labelled input. The hint is the input's description for screen readers, not a part of its name. */
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

/** A modal dialog. When it closes, the focus returns to the element that had it before. */
export function Dialog({ title, onClose, children }: { title: string; onClose: () => void; children: ComponentChildren }) {
  const box = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const previous = document.activeElement;
    box.current?.showModal();
    return () => {
      // The browser returns the focus when a dialog is closed, but not when it is removed from the page.
      if (document.activeElement === document.body && previous instanceof HTMLElement) previous.focus();
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
