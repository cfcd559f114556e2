// Where a copy stands among learners' copies.

import { render } from "preact";
import { expect, it } from "vitest";
import { language } from "../../src/i18n";
import { Standing } from "../../src/studio/mark/Verdict";

const shown = (percentile: number | null | undefined, chosen: "zh" | "en" = "en"): HTMLElement => {
  language.value = chosen;
  const box = document.createElement("div");
  render(<Standing mark={{ level: "good", level_text: { zh: "良", en: "good" }, percentile }} />, box);
  return box;
};

it("is told in tenths, with the level as a word", () => {
  const box = shown(68.4);
  expect(box.textContent).toBe("Better than 7 of 10 learners' copiesLevel: good");
  expect(box.querySelectorAll(".standing-row i")).toHaveLength(10);
  expect(box.querySelectorAll(".standing-row .passed")).toHaveLength(7);
  expect(shown(68.4, "zh").textContent).toContain("每十張裡比 7 張好");
});

it("has words of its own at both ends", () => {
  expect(shown(2).textContent).toContain("lowest tenth");
  expect(shown(0).textContent).toContain("lowest tenth");
  expect(shown(98).textContent).toContain("nearly all");
  expect(shown(100).querySelectorAll(".passed")).toHaveLength(10);
});

it("is not claimed by marks that do not know it", () => {
  for (const unknown of [null, undefined]) expect(shown(unknown).textContent).toBe("Level: good");
});
