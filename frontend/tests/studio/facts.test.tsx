// Facts in a row, of which some are not known.

import { render } from "preact";
import { describe, expect, it } from "vitest";
import { Facts } from "../../src/ui";

const shown = (items: Parameters<typeof Facts>[0]["items"]): string => {
  const box = document.createElement("p");
  render(<Facts items={items} />, box);
  return box.textContent ?? "";
};

describe("facts in a row", () => {
  it("have dots between them, and none for those that are empty", () => {
    expect(shown(["水", "", "  ", null, undefined, false, <a href="#/">open</a>, ""])).toBe("水 · open");
    expect(shown(["", "唐"])).toBe("唐");
    expect(shown([])).toBe("");
    expect(shown([0, "a"])).toBe("0 · a");
  });
});
