import { describe, expect, it } from "vitest";
import { DEFAULT_VIEW, normalizeView, stateFromQuery, stateToQuery, type ViewState } from "../../src/viewer/state";

const turned: ViewState = {
  mode: "heights",
  tilt: 212.5,
  slant: 70,
  exaggeration: 2.5,
  camera: [0.1, -0.2, 1.5, 0, 0.05, 0],
  section: [0.1, 0.2, 0.9, 0.8],
  ruler: [0, 0, 1, 1],
  lens: "magnify",
  look: "clay",
  mixture: true,
};

describe("a permalink", () => {
  it("restores the view", () => {
    expect(stateFromQuery(new URLSearchParams(stateToQuery(turned).toString()))).toEqual(turned);
  });

  it("is empty for the default view", () => {
    expect(stateToQuery(DEFAULT_VIEW).toString()).toBe("");
    expect(stateFromQuery(new URLSearchParams())).toEqual(DEFAULT_VIEW);
  });

  it("that is damaged still opens", () => {
    const query = new URLSearchParams("mode=horse&tilt=abc&slant=400&ex=-3&cam=1,2,3&sec=0,0,7,x&lens=&look=gold");
    expect(stateFromQuery(query)).toEqual({ ...DEFAULT_VIEW, slant: 88, exaggeration: 0 });
  });
});

describe("a state", () => {
  it("wraps angles", () => {
    expect(normalizeView({ ...DEFAULT_VIEW, tilt: -90 }).tilt).toBe(270);
    expect(normalizeView({ ...DEFAULT_VIEW, tilt: 725 }).tilt).toBe(5);
  });
});
