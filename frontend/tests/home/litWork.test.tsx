// A work at the head of a page: what is said of it when no lamp can be moved over it.

import { render } from "preact";
import { expect, it, vi } from "vitest";
import { LitWork } from "../../src/home/LitWork";
import { language } from "../../src/i18n";
import type { LampPicture } from "../../src/home/lampPicture";
import type { CoverWork } from "../../src/types";

const work = { id: "leaf", title: { zh: "葉", en: "A leaf" }, hand: { zh: "", en: "" }, height_source: "inflation", width: 3, height: 2, picture: "", normals: "", thumb: "" };

function shown(draw: () => Promise<LampPicture>): HTMLElement {
  language.value = "en";
  const box = document.createElement("div");
  render(<LitWork work={work as unknown as CoverWork} draw={draw} />, box);
  return box;
}
const hints = (box: HTMLElement): number => box.querySelectorAll("figcaption small").length;

it("speaks of a lamp and of heights only where a lamp shines", async () => {
  const lit = shown(() => Promise.resolve({ light: () => undefined, dispose: () => undefined }));
  await vi.waitFor(() => expect(lit.querySelector("canvas.lit")).not.toBeNull());
  expect(hints(lit)).toBe(2);
  const flat = shown(() => Promise.reject(new Error("422: nothing to light")));
  await vi.waitFor(() => expect(hints(flat)).toBe(0));
});
