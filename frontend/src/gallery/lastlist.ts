// The last list of the gallery, so that coming back from a work finds it where it was.

import type { WorkCard } from "../types";

type List = { key: string; items: WorkCard[]; total: number; scroll: number };

let kept: List | null = null;

export const lastList = (key: string): List | null => (kept?.key === key ? kept : null);
export const keepList = (list: List): void => void (kept = list);

/** After a change of the works the list is asked for anew. */
export const forgetList = (): void => void (kept = null);
