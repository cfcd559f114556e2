// What an attempt changed against the one before.

import { render } from "preact";
import { expect, it } from "vitest";
import { language } from "../../src/i18n";
import { Progress } from "../../src/studio/mark/Progress";
import type { FaultChange, Progress as Changed } from "../../src/types";

const fault = (status: FaultChange["status"], remark: number | null = null): FaultChange => ({ status, kind: "lean", stroke: null, remark, zh: `${status}。`, en: `${status}.` });
const changed = (faults: FaultChange[]): Changed => ({
  previous: { id: "p1", created: "2026-11-01T10:00:00Z" },
  mark: { before: 40, after: 55, change: "better", zh: "整體比上一張好：40 → 55。", en: "Better as a whole: 40 → 55." },
  parts: [{ name: "ink", zh: "墨法", en: "Ink", before: 50.4, after: 49, change: "same" }],
  faults,
});
const shown = (progress: Changed, chosen: "zh" | "en" = "en"): HTMLElement => {
  language.value = chosen;
  const box = document.createElement("div");
  render(<Progress progress={progress} />, box);
  return box;
};

it("what got better stands apart from what did not, with the remark that tells it", () => {
  const box = shown(changed([fault("gone"), fault("smaller", 1), fault("same", 0), fault("larger", 2), fault("turned"), fault("new")]));
  const [better, open] = [...box.querySelectorAll(".progress-faults")].map((list) => [...list.querySelectorAll("li")].map((line) => line.className));
  expect(better).toEqual(["gone", "smaller"]);
  expect(open).toEqual(["same", "larger", "turned", "new"]);
  expect(box.querySelector(".smaller")!.textContent).toContain("remark 2");
  expect(box.querySelector(".gone")!.textContent).not.toContain("remark");
  expect(box.querySelector("a")!.getAttribute("href")).toBe("#/attempts/p1");
});

it("numbers and words are in the reader's language", () => {
  expect(shown(changed([])).textContent).toContain("Ink 50 → 49 about the same");
  const zh = shown(changed([fault("gone")]), "zh").textContent!;
  for (const words of ["和上一張比", "整體比上一張好：40 → 55。", "墨法 50 → 49 差不多", "好了的", "只列出大過量測誤差的變化"]) expect(zh).toContain(words);
  expect(zh).not.toContain("還沒好的");
});

it("no change of a fault is said, too", () => {
  expect(shown(changed([])).textContent).toContain("none has changed for certain");
});
