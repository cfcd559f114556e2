// A work at the head of a page: what is said of it when no lamp can be moved over it.

import { render } from "preact";
import { expect, it, vi } from "vitest";
import { LitWork } from "../../src/home/LitWork";
import { language } from "../../src/i18n";
import type { CoverWork } from "../../src/types";

const made = vi.hoisted(() => ({ picture: (): Promise<unknown> => new Promise(() => undefined) }));
vi.mock("../../src/home/lampPicture", () => ({ createLampPicture: () => made.picture() }));

const work = { id: "leaf", title: { zh: "葉", en: "A leaf" }, hand: { zh: "", en: "" }, height_source: "inflation", width: 3, height: 2, picture: "", normals: "", thumb: "" };

function shown(picture: () => Promise<unknown>): HTMLElement {
  made.picture = picture;
  language.value = "en";
  const box = document.createElement("div");
  render(<LitWork work={work as unknown as CoverWork} />, box);
  return box;
}
const PATIENCE = { timeout: 4_000 }; // for a busy machine
const hints = (box: HTMLElement): number => box.querySelectorAll("figcaption small").length;

it("speaks of a lamp and of heights only where a lamp shines", async () => {
  const lit = shown(() => Promise.resolve({ light: () => undefined, dispose: () => undefined }));
  await vi.waitFor(() => expect(lit.querySelector("canvas.lit")).not.toBeNull(), PATIENCE);
  expect(hints(lit)).toBe(2);
  const flat = shown(() => Promise.reject(new Error("422: nothing to light")));
  await vi.waitFor(() => expect(hints(flat)).toBe(0), PATIENCE);
});
