import { expect, test } from "vitest";
import { writtenAfter } from "../../src/strokes/StrokeOrder";

test("strokes are written one after another, with a pause between them", () => {
  const lengths = [1.1, 0.55]; // a second, and half of one
  expect(writtenAfter(0, lengths)).toEqual({ count: 0, share: 0 });
  expect(writtenAfter(0.5, lengths)).toEqual({ count: 0, share: expect.closeTo(0.5) });
  expect(writtenAfter(1.1, lengths)).toEqual({ count: 1, share: 0 });
  expect(writtenAfter(1.5, lengths)).toEqual({ count: 1, share: expect.closeTo(0.5) });
  expect(writtenAfter(1.8, lengths)).toEqual({ count: 2, share: 0 });
  expect(writtenAfter(60, lengths)).toEqual({ count: 2, share: 0 });
});
