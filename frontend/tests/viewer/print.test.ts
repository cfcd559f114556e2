import { describe, expect, it } from "vitest";
import { printUrl } from "../../src/viewer/PrintForm";

describe("the download for a printer", () => {
  const url = "/api/works/a/files/stl?v=1";

  it("asks for the width, the base and the relief that were chosen", () => {
    expect(printUrl(url, { width: "80", base: "3.5", exaggeration: 2 })).toBe(`${url}&download=1&width=80&base=3.5&exaggeration=2`);
    expect(printUrl(url, { width: "80", base: "2", exaggeration: 0 })).toBe(`${url}&download=1&width=80&exaggeration=0.01`);
  });

  it("leaves to the service what is empty, usual or out of range", () => {
    expect(printUrl(url, { width: "", base: "2", exaggeration: 1 })).toBe(`${url}&download=1`);
    expect(printUrl("/f", { width: "1e9", base: "-1", exaggeration: 1 })).toBe("/f?download=1");
    expect(printUrl(url, { width: "wide", base: "NaN", exaggeration: 1.0004 })).toBe(`${url}&download=1`);
  });
});
