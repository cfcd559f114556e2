// All requests to the service: JSON in, JSON out, with the CSRF token on every request that changes something.

import { signal } from "@preact/signals";
import type { Bilingual, SessionFacts } from "./types";

export const session = signal<SessionFacts | null>(null);

/** An error response of the service; its message comes in both languages. */
export class ServiceError extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    readonly text: Bilingual,
  ) {
    super(text.en);
  }
}

export async function refreshSession(): Promise<SessionFacts> {
  const facts = await get<SessionFacts>("api/session");
  session.value = facts;
  return facts;
}

export const get = <T>(url: string, signal?: AbortSignal): Promise<T> => request<T>("GET", url, undefined, signal);
export const post = <T>(url: string, body?: object | FormData): Promise<T> => request<T>("POST", url, body);
export const put = <T>(url: string, body: object): Promise<T> => request<T>("PUT", url, body);
export const patch = <T>(url: string, body: object): Promise<T> => request<T>("PATCH", url, body);
export const remove = <T>(url: string): Promise<T> => request<T>("DELETE", url);

/** A query string with its question mark; empty values are left out. */
export function query(values: Record<string, string | number | null | undefined>): string {
  const pairs = Object.entries(values).filter(([, value]) => value !== null && value !== undefined && value !== "");
  return pairs.length ? `?${new URLSearchParams(pairs.map(([name, value]) => [name, String(value)]))}` : "";
}

/** Sends a form and returns the picture that the service makes of it. */
export async function postForPicture(url: string, body: FormData): Promise<Blob> {
  const response = await send("POST", url, body);
  if (!response.ok) throw serviceError(response.status, await response.json().catch(() => null));
  return response.blob();
}

async function request<T>(method: string, url: string, body?: object | FormData, signal?: AbortSignal): Promise<T> {
  const response = await send(method, url, body, signal);
  if (response.status === 204) return undefined as T;
  const json: unknown = await response.json().catch(() => null);
  if (!response.ok) throw serviceError(response.status, json);
  return json as T;
}

async function send(method: string, url: string, body?: object | FormData, signal?: AbortSignal): Promise<Response> {
  const headers: Record<string, string> = { Accept: "application/json" };
  if (method !== "GET") headers["X-CSRF-Token"] = (session.value ?? (await refreshSession())).csrf;
  if (body && !(body instanceof FormData)) headers["Content-Type"] = "application/json";
  const payload = body instanceof FormData ? body : body && JSON.stringify(body);
  try {
    return await fetch(url, { method, headers, body: payload ?? null, signal: signal ?? null, credentials: "same-origin" });
  } catch (error) {
    if (signal?.aborted) throw error;
    throw new ServiceError(0, "offline", { zh: "連不上伺服器，請稍後再試。", en: "The server cannot be reached; try again." });
  }
}

function serviceError(status: number, json: unknown): ServiceError {
  const error = (json as { error?: { code?: string; zh?: string; en?: string } } | null)?.error;
  const fallback = { zh: `伺服器回覆 ${status}。`, en: `The server answered ${status}.` };
  return new ServiceError(status, error?.code ?? "unknown", {
    zh: error?.zh ?? fallback.zh,
    en: error?.en ?? fallback.en,
  });
}
