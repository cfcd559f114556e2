// A whole work: the columns of its text, the character under a point, text and picture linked, and one character by all hands.

import { render } from "preact";
import { act } from "preact/test-utils";
import { describe, expect, it, vi } from "vitest";
import { CharacterCard, CharacterLinks } from "../../src/gallery/CharacterFacts";
import { GatheredView } from "../../src/gallery/GatherPage";
import { characterAt, columnsOf, isWithin } from "../../src/gallery/wholeWork";
import WorkPage from "../../src/gallery/WorkPage";
import { WorkText } from "../../src/gallery/WorkText";
import { language } from "../../src/i18n";
import type { CharacterWithin, Work, WorkCard } from "../../src/types";

const square = (x: number, y: number, side = 0.1): [number, number][] => [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
const character = (id: string, name: string, column: number, row: number, more: Partial<CharacterWithin["place"]> = {}): CharacterWithin => ({
  id,
  character: name,
  place: { polygon: square(0.8 - column * 0.2, 0.1 + row * 0.2), register: 0, column, row, small: null, certainty: 1, direction: "vertical", ...more },
});
const SCROLL = [character("a", "永", 0, 0), character("b", "和", 0, 1), character("c", "", 1, 0), character("d", "之", 1, 1)];

const shown = (what: preact.ComponentChild): HTMLElement => {
  const box = document.createElement("div");
  document.body.append(box);
  act(() => render(what, box));
  return box;
};

describe("the characters of a whole work", () => {
  it("stand in columns as they are read, and a new register begins a new column", () => {
    expect(columnsOf(SCROLL).map((column) => column.map((one) => one.id).join(""))).toEqual(["ab", "cd"]);
    const next = character("e", "水", 1, 2, { register: 1 });
    expect(columnsOf([...SCROLL, next]).length).toBe(3);
    expect(columnsOf([])).toEqual([]);
  });

  it("are found under a point of the picture, the nearer one where two overlap", () => {
    expect(characterAt(SCROLL, { x: 0.85, y: 0.15 })?.id).toBe("a");
    expect(characterAt(SCROLL, { x: 0.65, y: 0.35 })?.id).toBe("d");
    expect(characterAt(SCROLL, { x: 0.5, y: 0.5 })).toBeNull();
    const over = character("e", "天", 0, 0, { polygon: square(0.84, 0.14) });
    expect(characterAt([...SCROLL, over], { x: 0.89, y: 0.19 })?.id).toBe("e");
  });

  it("have outlines of any form", () => {
    const hollow: [number, number][] = [[0, 0], [1, 0], [1, 1], [0.5, 0.2], [0, 1]];
    expect(isWithin({ x: 0.1, y: 0.5 }, hollow)).toBe(true);
    expect(isWithin({ x: 0.5, y: 0.9 }, hollow)).toBe(false);
  });
});

describe("a work whose surface is still being computed", () => {
  it("says at once what it is, with a small picture", async () => {
    language.value = "en";
    const both = (text: string) => ({ zh: text, en: text });
    const work = {
      id: "scroll", title: both("A scroll"), hand: both(""), period: both(""), material: both(""), dynasty: "", script: "", width: 30, height: 20, source: "", licence: "CC0-1.0",
      attribution: "", collection: "own", collection_title: both("Own"), character: "", within: null, record: null, previous: null, next: null, thumb: "thumb.webp",
    };
    const asked = vi.spyOn(globalThis, "fetch").mockImplementation((url) =>
      String(url).endsWith("/viewer") ? new Promise(() => undefined) : Promise.resolve(new Response(JSON.stringify(work), { headers: { "Content-Type": "application/json" } })),
    );
    const box = shown(<WorkPage params={{ id: "scroll" }} query={new URLSearchParams()} />);
    await vi.waitFor(() => expect(box.querySelector("h1")?.textContent).toBe("A scroll"));
    expect(box.querySelector("img")!.getAttribute("src")).toBe("thumb.webp");
    expect(box.querySelector("[role=status]")).not.toBeNull();
    act(() => render(null, box));
    asked.mockRestore();
  });

  it("is told to be missing where there is none, and nothing else goes wrong", async () => {
    const error = { error: { code: "missing", zh: "沒有這件作品。", en: "There is no such work." } };
    const asked = vi.spyOn(globalThis, "fetch").mockImplementation(() =>
      Promise.resolve(new Response(JSON.stringify(error), { status: 404, headers: { "Content-Type": "application/json" } })),
    );
    const box = shown(<WorkPage params={{ id: "none" }} query={new URLSearchParams()} />);
    await vi.waitFor(() => expect(box.querySelector("h1")?.textContent).toBe("There is no such work."));
    act(() => render(null, box));
    asked.mockRestore();
  });
});

describe("the text of a whole work", () => {
  const acts = () => ({ light: vi.fn(), choose: vi.fn(), show: vi.fn() });
  const text = (more: object = {}) => ({ characters: SCROLL, lit: null, chosen: null, shown: false, ...acts(), ...more });

  it("says each character in its column, and 〓 where one is not known", () => {
    const columns = [...shown(<WorkText {...text()} />).querySelectorAll("p")].map((one) => one.textContent);
    expect(columns).toEqual(["永和", "〓之"]);
  });

  it("tells what is pointed at and what is chosen, and takes the choice back", () => {
    const props = text({ chosen: SCROLL[1] });
    const buttons = shown(<WorkText {...props} />).querySelectorAll("button");
    expect([...buttons].map((one) => one.getAttribute("aria-pressed"))).toEqual(["false", "true", "false", "false"]);
    buttons[3]!.click();
    buttons[1]!.click();
    buttons[0]!.dispatchEvent(new Event("pointerenter"));
    expect(props.choose.mock.calls).toEqual([[SCROLL[3]], [null]]);
    expect(props.light.mock.calls).toEqual([[SCROLL[0]]]);
  });

  it("is one stop of the tabulator, and the arrows go through it: down the column, and to the next on the left", () => {
    const box = shown(<WorkText {...text()} />);
    const buttons = [...box.querySelectorAll("button")];
    expect(buttons.map((one) => one.tabIndex)).toEqual([0, -1, -1, -1]);
    const press = (key: string) => document.activeElement!.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
    buttons[0]!.focus();
    press("ArrowDown");
    expect(document.activeElement).toBe(buttons[1]);
    press("ArrowLeft");
    expect(document.activeElement).toBe(buttons[3]);
    press("End");
    press("ArrowRight");
    expect(document.activeElement).toBe(buttons[1]);
  });
});

describe("a character within a work", () => {
  it("says where it stands and leads to itself, to writing it, and to other hands", () => {
    language.value = "en";
    const card = shown(<CharacterCard one={character("a-1", "永", 2, 4, { certainty: 0.3 })} />);
    expect(card.querySelector("p")!.textContent).toBe("column 3, character 5 · the reading is uncertain");
    expect([...card.querySelectorAll("a")].map((one) => one.getAttribute("href"))).toEqual(["#/works/a-1", "#/studio/a-1", `#/characters/${encodeURIComponent("永")}`]);
    const unknown = shown(<CharacterCard one={SCROLL[2]!} />);
    expect([...unknown.querySelectorAll("a")].length).toBe(1);
  });

  it("leads back to its place on the page, and to its brothers there", () => {
    const within = { id: "scroll", title: { zh: "蘭亭序", en: "Lanting" }, place: SCROLL[0]!.place, same: ["a", "d"] };
    const links = shown(<CharacterLinks work={{ id: "a", character: "之", within } as Work} />);
    expect(links.querySelector("a")!.getAttribute("href")).toBe("#/works/scroll?at=a");
    expect([...links.querySelectorAll(".same a")].map((one) => [one.getAttribute("href"), one.getAttribute("aria-current")])).toEqual([["#/works/a", "page"], ["#/works/d", null]]);
    expect(shown(<CharacterLinks work={{ id: "w", character: "", within: null } as Work} />).innerHTML).toBe("");
  });
});

describe("one character by all hands", () => {
  const card = (id: string): WorkCard => ({ id, title: { zh: id, en: id }, thumb: "t.webp", thumb_normals: "n.webp", height_source: "inflation" }) as WorkCard;
  const hand = (name: string, ...ids: string[]) => ({ hand: { zh: name, en: name }, time: { zh: "唐", en: "Tang" }, works: ids.map(card) });
  const gathered = { character: "永", total: 3, hands: 2, scripts: [{ script: "regular", hands: [hand("歐陽詢", "o")] }, { script: "running", hands: [hand("馮承素", "f", "g")] }] };

  it("stands by script and hand, and two that are chosen lie side by side", () => {
    language.value = "zh";
    const box = shown(<GatheredView gathered={gathered} />);
    expect([...box.querySelectorAll("h2")].map((one) => one.textContent)).toEqual(["楷書", "行書"]);
    const [first, second, third] = [...box.querySelectorAll<HTMLButtonElement>("li button")];
    for (const one of [first!, second!, third!]) act(() => one.click());
    expect([...box.querySelectorAll("li button")].map((one) => one.getAttribute("aria-pressed"))).toEqual(["false", "true", "true"]);
    expect(box.querySelector(".compare-bar a")!.getAttribute("href")).toBe("#/works/f?with=g");
    act(() => second!.click());
    expect(box.querySelector(".compare-bar a")).toBeNull();
  });
});
