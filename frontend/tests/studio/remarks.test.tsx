// Remarks with the strokes they speak of, in the master and in the copy.

import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { Remarks } from "../../src/studio/mark/Remarks";
import type { Remark, WorkCard } from "../../src/types";

const work = { id: "regular-shui", title: { zh: "水", en: "shui" }, thumb: "thumb.png", width: 512, height: 512 } as WorkCard;
const remark = (part: Partial<Remark>): Remark => ({ kind: "stroke_short", name: { zh: "筆畫太短", en: "Stroke too short" }, zh: "橫短了。", en: "Too short.", severity: 3, size: -0.2, unit: "of the master", region: null, outline: [], ...part });
const line: [number, number][][] = [[[0.2, 0.4], [0.8, 0.4]]];
const other: [number, number][][] = [[[0.5, 0.2], [0.5, 0.9]]];

let box: HTMLElement;
beforeEach(() => {
  vi.stubGlobal("fetch", () => new Promise(() => undefined));
  box = document.createElement("div");
  document.body.append(box);
});
afterEach(() => {
  act(() => render(null, box));
  box.remove();
  vi.unstubAllGlobals();
});

const show = (remarks: Remark[]) => act(() => render(<Remarks remarks={remarks} picture="copy.png" work={work} />, box));
const sheets = () => [...box.querySelectorAll(".sheet")] as [Element, Element];
const lines = (sheet: Element, state = "") => sheet.querySelectorAll(`.outline${state} polyline:not(.outline-halo)`).length;
const badges = (sheet: Element) => [...sheet.querySelectorAll(".remark-badge")].map((badge) => badge.textContent);
const say = (k: number) => box.querySelectorAll<HTMLButtonElement>(".remark")[k]!;
const pointer = (type: string, pointerType: string) => Object.assign(new Event(type, { bubbles: true }), { pointerType });

it("the strokes of a remark are drawn, and numbered, in both", () => {
  show([remark({ outline: line, master_outline: line }), remark({ outline: other, master_outline: other })]);
  const [master, copy] = sheets();
  for (const sheet of [master, copy]) {
    expect(lines(sheet)).toBe(2);
    expect(badges(sheet)).toEqual(["1", "2"]);
  }
});

it("marks of older versions, which know nothing of the master, are shown on the copy alone", () => {
  show([remark({ outline: line }), remark({ kind: "lean" })]);
  const [master, copy] = sheets();
  expect(badges(master)).toEqual([]);
  expect(badges(copy)).toEqual(["1", "2"]);
  expect(lines(copy)).toBe(1);
});

it("pointing at a remark, or at its number, makes its strokes stand out in both", () => {
  show([remark({ outline: line, master_outline: line }), remark({ outline: other, master_outline: other })]);
  const on = () => sheets().map((sheet) => lines(sheet, ".on"));
  expect(on()).toEqual([0, 0]);
  act(() => void say(1).dispatchEvent(pointer("pointerenter", "mouse")));
  expect(on()).toEqual([1, 1]);
  expect(sheets()[0].querySelector(".remark-badge.on")!.textContent).toBe("2");
  act(() => void say(1).dispatchEvent(pointer("pointerleave", "mouse")));
  expect(on()).toEqual([0, 0]);
  act(() => void sheets()[0].querySelector(".remark-badge")!.dispatchEvent(pointer("pointerenter", "mouse")));
  expect(on()).toEqual([1, 1]);
  expect(say(0).classList.contains("on")).toBe(true);
});

it("a tap keeps a remark, a second one lets it go", () => {
  show([remark({ outline: line, master_outline: line }), remark({ outline: other, master_outline: other })]);
  const tap = (element: Element) =>
    act(() => {
      element.dispatchEvent(pointer("pointerenter", "touch"));
      element.dispatchEvent(pointer("pointerleave", "touch"));
      element.dispatchEvent(new Event("click", { bubbles: true }));
    });
  const pressed = () => [0, 1].map((k) => say(k).getAttribute("aria-pressed"));
  tap(say(0));
  expect(pressed()).toEqual(["true", "false"]);
  expect(lines(sheets()[0], ".on")).toBe(1);
  tap(say(0));
  expect(pressed()).toEqual(["false", "false"]);
  expect(lines(sheets()[0], ".on")).toBe(0);
  tap(sheets()[1].querySelectorAll(".outline-reach")[1]!); // the stroke itself
  expect(pressed()).toEqual(["false", "true"]);
  tap(sheets()[0].querySelector(".remark-badge")!);
  expect(pressed()).toEqual(["true", "false"]);
});

it("a missing stroke is drawn where it should stand", () => {
  show([remark({ kind: "missing", outline: line, master_outline: line })]);
  const [master, copy] = sheets();
  expect(copy.querySelectorAll(".outline.absent")).toHaveLength(1);
  expect(master.querySelectorAll(".outline.absent")).toHaveLength(0);
});
