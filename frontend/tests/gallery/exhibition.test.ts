import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { moved } from "../../src/gallery/CollectionPage";
import { enterKiosk, isShown, kiosk, leaveKiosk, secondsOf, watchScreen } from "../../src/kiosk";

describe("the order of works", () => {
  it("takes one work to another place", () => {
    expect(moved(["a", "b", "c", "d"], 3, 0)).toEqual(["d", "a", "b", "c"]);
    expect(moved(["a", "b", "c", "d"], 0, 1)).toEqual(["b", "a", "c", "d"]);
    expect(moved(["a", "b"], 1, 1)).toEqual(["a", "b"]);
  });
});

describe("a screen in an exhibition", () => {
  let idle = vi.fn();
  let end = () => {};
  beforeEach(() => {
    vi.useFakeTimers();
    idle = vi.fn();
    location.hash = "#/collections/stele";
    end = watchScreen(idle);
  });
  afterEach(() => {
    end();
    leaveKiosk();
    vi.useRealTimers();
  });
  const click = (href: string): boolean => {
    const link = document.createElement("a");
    link.setAttribute("href", href);
    document.body.append(link);
    const followed = link.dispatchEvent(new MouseEvent("click", { bubbles: true, cancelable: true }));
    link.remove();
    return followed;
  };

  it("waits for seconds that make sense", () => {
    expect(["30", "1", "99999", "", "soon", "NaN"].map(secondsOf)).toEqual([30, 10, 3600, 90, 90, 90]);
  });

  it("keeps visitors among works, tours and collections", () => {
    expect(["#/works/a?light=1", "#/tours/a", "#/collections/a", "#/characters/永"].every(isShown)).toBe(true);
    expect(["#/login", "#/studio/a", "#/collections", "https://example.org", "#main", ""].some(isShown)).toBe(false);
    expect(click("https://example.org/")).toBe(true);
    enterKiosk({ path: "/collections/stele", seconds: 20 });
    expect([click("https://example.org/"), click("#/login"), click("#/works/a")]).toEqual([false, false, true]);
    leaveKiosk();
    expect(click("#/login")).toBe(true);
  });

  it("goes back to its page when nobody touches it, and then does what is to happen there", () => {
    enterKiosk({ path: "/collections/stele", seconds: 20 });
    location.hash = "#/works/a";
    dispatchEvent(new HashChangeEvent("hashchange"));
    vi.advanceTimersByTime(15_000);
    dispatchEvent(new Event("pointerdown"));
    vi.advanceTimersByTime(15_000);
    expect(location.hash).toBe("#/works/a");
    vi.advanceTimersByTime(5_000);
    expect(location.hash).toBe("#/collections/stele");
    dispatchEvent(new HashChangeEvent("hashchange"));
    expect(idle).not.toHaveBeenCalled();
    vi.advanceTimersByTime(20_000);
    expect(idle).toHaveBeenCalledOnce();
  });

  it("leaves a tour that plays by itself alone", () => {
    enterKiosk({ path: "/collections/stele", seconds: 20 });
    location.hash = "#/tours/a?play=1";
    dispatchEvent(new HashChangeEvent("hashchange"));
    vi.advanceTimersByTime(100_000);
    expect(location.hash).toBe("#/tours/a?play=1");
  });

  it("remembers that it is one over a reload, until it is told otherwise", () => {
    enterKiosk({ path: "/collections/stele", seconds: 20 });
    expect(JSON.parse(sessionStorage.getItem("kiosk")!)).toEqual({ path: "/collections/stele", seconds: 20 });
    leaveKiosk();
    expect([kiosk.value, sessionStorage.getItem("kiosk")]).toEqual([null, null]);
  });
});
