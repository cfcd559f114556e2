// What an owner changed of what is known of a work.

import type { Text, Work } from "../types";

const BOTH = ["title", "hand", "period", "material"] as const;
const ONE = ["character", "script", "dynasty", "source", "licence", "attribution"] as const;
const UNSTATED = "none stated";

export type WorkChange = Partial<Record<(typeof BOTH)[number], Text> & Record<(typeof ONE)[number], string> & { spacing: number | null }>;

/** A licence as it stands in a field: the service's "none stated" is an empty one. */
export const licenceField = (licence: string): string => (licence === UNSTATED ? "" : licence);

/** The facts of a form that differ from the work's; what the form does not ask stays, so that two owners do not undo each other. */
export function changesOf(work: Work, form: FormData): WorkChange {
  const said = (name: string, before: string) => (form.has(name) ? plain(String(form.get(name))) : plain(before));
  const changes: WorkChange = {};
  for (const name of BOTH) {
    const before = work[name];
    const now = { zh: said(`${name}_zh`, before.zh), en: said(`${name}_en`, before.en) };
    if (now.zh !== plain(before.zh) || now.en !== plain(before.en)) changes[name] = now;
  }
  for (const name of ONE) {
    const before = name === "licence" ? licenceField(work[name]) : work[name];
    const now = said(name, before);
    if (now !== plain(before)) changes[name] = now;
  }
  if (form.has("spacing")) {
    const spacing = said("spacing", "") === "" ? null : Number(form.get("spacing"));
    if (spacing !== work.spacing) changes.spacing = spacing;
  }
  return changes;
}

/** Line ends as the service keeps them: a browser's form may send others. */
const plain = (text: string): string => text.replace(/\r\n?/g, "\n").trim();
