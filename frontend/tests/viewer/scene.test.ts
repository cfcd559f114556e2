import { PerspectiveCamera, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { layoutPlot } from "../../src/viewer/scales";
import { HeightField, smoothed } from "../../src/viewer/heightfield";
import { type Camera, lightAt } from "../../src/viewer/state";
import { FIELD_OF_VIEW, fitCamera, orbit, pan, zoom } from "../../src/viewer/camera";
import { grid } from "../../src/viewer/grid";

/** A cone, 10 high, over the middle of 40 x 20 pixels. */
function cone(): HeightField {
  const values = Float32Array.from({ length: 800 }, (_, k) => Math.max(0, 10 - 2 * Math.hypot((k % 40) - 19.5, Math.floor(k / 40) - 9.5)));
  return new HeightField(values, 40, 20, 0, 10, { width: 40, height: 20, spacing: 1, unit: "px" });
}

describe("the mesh", () => {
  it("has faces towards the camera, and rows that go down", () => {
    const mesh = grid({ wide: 1, tall: 0.5 }, 8);
    const [at, uv, faces] = [mesh.getAttribute("position"), mesh.getAttribute("uv"), mesh.getIndex()!];
    for (let k = 0; k < faces.count; k += 3) {
      const [a, b, c] = [faces.getX(k), faces.getX(k + 1), faces.getX(k + 2)];
      const turn = (at.getX(b) - at.getX(a)) * (at.getY(c) - at.getY(a)) - (at.getY(b) - at.getY(a)) * (at.getX(c) - at.getX(a));
      expect(turn).toBeGreaterThan(0);
    }
    for (let k = 0; k < at.count; k++) expect(at.getY(k)).toBeCloseTo((0.5 - uv.getY(k)) * 0.5);
  });

  it.each([1, -1])("folds its squares along a wall, whichever way that runs (%i)", (way) => {
    const height = (u: number, v: number) => Math.min(1, Math.max(0, 4 * (way > 0 ? v - u : v - 1 + u)));
    const mesh = grid({ wide: 1, tall: 1 }, 8, height);
    const [uv, faces] = [mesh.getAttribute("uv"), mesh.getIndex()!];
    const corners = Array.from({ length: faces.count }, (_, k) => [uv.getX(faces.getX(k)), uv.getY(faces.getX(k))] as const);
    for (let k = 0; k < faces.count; k += 3) {
      const three = corners.slice(k, k + 3);
      const areaTwice = three.map(([u, v], n) => { const [x, y] = three[(n + 1) % 3]!; return u * y - x * v; }).reduce((sum, part) => sum + part);
      expect(areaTwice).toBeLessThan(0); // towards the camera
      // At the middle of each side the face is as high as the wall: a square folded the other way cuts through it.
      three.forEach(([u, v], n) => {
        const [x, y] = three[(n + 1) % 3]!;
        const slanted = u !== x && v !== y;
        if (slanted) expect((height(u, v) + height(x, y)) / 2).toBeCloseTo(height((u + x) / 2, (v + y) / 2), 6);
      });
    }
  });
});

describe("heights averaged over squares of the mesh", () => {
  const plane = Float32Array.from({ length: 800 }, (_, k) => 2 + 0.5 * (k % 40) - 0.25 * Math.floor(k / 40));

  it("leave a plane as it is, but at its rim", () => {
    const smooth = smoothed({ values: plane, width: 40, height: 20 }, 4);
    for (const [c, r] of [[8, 8], [20, 10], [31, 11]] as const) expect(smooth[r * 40 + c]).toBeCloseTo(plane[r * 40 + c]!, 4);
  });

  it("turn a wall into a ramp as wide as their reach, of the same volume", () => {
    const wall = Float32Array.from({ length: 800 }, (_, k) => (k % 40 < 20 ? 0 : 10));
    const smooth = smoothed({ values: wall, width: 40, height: 20 }, 4).slice(400, 440);
    expect([smooth[15], smooth[24]]).toEqual([0, 10]);
    for (let c = 16; c < 24; c++) expect(smooth[c]! - smooth[c - 1]!).toBeGreaterThan(0.3);
    expect(smooth.reduce((a, b) => a + b)).toBeCloseTo(200, 3);
  });

  it("take nothing from where nothing was measured", () => {
    const pit = plane.map((value, k) => (k % 40 < 20 ? value : -1000));
    const measured = Float32Array.from(pit, (value) => (value === -1000 ? 0 : 1));
    const smooth = smoothed({ values: pit, width: 40, height: 20 }, 4, measured);
    expect(Math.min(...smooth.filter((_, k) => k % 40 < 20))).toBeGreaterThan(-3);
    expect(smooth[10 * 40 + 35]).toBe(-1000);
  });
});

describe("a ray from the camera", () => {
  it("meets the flat sheet", () => {
    const rows = cone().intersectRay([0.25, -0.125, 2], [0, 0, -1], 0);
    expect(rows).toEqual({ u: 0.75, v: 0.75 });
    expect(cone().intersectRay([0.75, 0, 2], [0, 0, -1], 0)).toBeNull();
  });

  it("meets the near slope of a raised cone before the paper behind it", () => {
    const field = cone();
    const aslant = { x: -1, z: 1 };
    const length = Math.hypot(aslant.x, aslant.z);
    const rows = field.intersectRay([aslant.x, 0, aslant.z], [-aslant.x / length, 0, -aslant.z / length], 2);
    const flat = field.intersectRay([aslant.x, 0, aslant.z], [-aslant.x / length, 0, -aslant.z / length], 0);
    expect(flat!.u).toBeCloseTo(0.5);
    expect(rows!.u).toBeLessThan(0.45);
    expect(rows!.v).toBeCloseTo(0.5);
  });
});

describe("the lamp under a pointer", () => {
  it("is straight above in the middle, and tilted towards the pointer elsewhere", () => {
    const box = { width: 200, height: 100 };
    expect(lightAt(100, 50, box).slant).toBe(0);
    expect(lightAt(100, 25, box)).toEqual({ tilt: 90, slant: 30.000000000000004 });
    expect(lightAt(65, 15, box).tilt).toBeCloseTo(135);
    expect(lightAt(0, 50, box)).toEqual({ tilt: 180, slant: 88 });
  });
});

describe("the camera", () => {
  const start: Camera = [0, 0, 2, 0, 0, 0];
  const distance = ([x, y, z, a, b, c]: Camera) => Math.hypot(x - a, y - b, z - c);

  it("orbits at the same distance and never gets behind the sheet", () => {
    let camera = start;
    for (let k = 0; k < 50; k++) camera = orbit(camera, 0.3, 0.2);
    expect(distance(camera)).toBeCloseTo(2);
    expect(camera[2]).toBeGreaterThan(0);
  });

  it("zooms towards the pointer", () => {
    const field = 2 * 2 * Math.tan((14 * Math.PI) / 180);
    const nearer = zoom(start, 0.5, 0.25, 0.1);
    expect(distance(nearer)).toBeCloseTo(1);
    expect(nearer[3]).toBeCloseTo(0.25 * field * 0.5);
    expect(nearer[4]).toBeCloseTo(0.1 * field * 0.5);
  });

  it("pans in the image plane", () => {
    const moved = pan(start, 0.1, 0);
    expect(moved[3]).toBeGreaterThan(0);
    expect(distance(moved)).toBeCloseTo(2);
    expect(pan(start, 0, 0.1)[4]).toBeGreaterThan(0);
  });

  it("sees a wide sheet whole on a narrow screen", () => {
    const [, , far] = fitCamera("sheet", { wide: 1, tall: 0.4 }, 0.5);
    const [, , near] = fitCamera("sheet", { wide: 1, tall: 0.4 }, 2);
    expect(far).toBeGreaterThan(near * 1.9);
    expect(Math.tan((14 * Math.PI) / 180) * far * 0.5).toBeGreaterThan(0.5);
  });

  it.each(["sheet", "surface", "mesh", "heights"] as const)("sees every corner by default: %s", (mode) => {
    for (const aspect of [0.4, 1, 1.6, 3]) {
      for (const sheet of [{ wide: 1, tall: 1 }, { wide: 1, tall: 0.2 }, { wide: 0.3, tall: 1 }]) {
        const eye = new PerspectiveCamera(FIELD_OF_VIEW, aspect);
        const [x, y, z, ...aim] = fitCamera(mode, sheet, aspect);
        eye.position.set(x, y, z);
        eye.lookAt(...aim);
        eye.updateMatrixWorld();
        const seen = [-1, 1].flatMap((i) => [-1, 1].map((k) => new Vector3((i * sheet.wide) / 2, (k * sheet.tall) / 2, 0).project(eye)));
        const most = Math.max(...seen.flatMap((p) => [Math.abs(p.x), Math.abs(p.y)]));
        expect(most).toBeLessThan(0.97);
        expect(most).toBeGreaterThan(0.88);
      }
    }
  });
});

describe("a plotted section", () => {
  it("plots height upward and distance to the right", () => {
    const drawn = layoutPlot([{ distance: 0, height: 0 }, { distance: 10, height: 5 }], { left: 0, right: 100, top: 0, bottom: 50 });
    expect(drawn.x(10)).toBe(100);
    expect(drawn.y(5)).toBeLessThan(drawn.y(0));
    expect(drawn.up).toContain(4);
  });
});
