import { translator } from "./index";

export const t = translator({
  strokeOrder: { zh: "筆順", en: "Stroke order" },
  strokeOrderNote: { zh: "楷書的標準筆順，共 {n} 筆。", en: "The standard order of regular script: {n} strokes." },
  strokeOrderNoteOne: { zh: "楷書的標準筆順，只有 1 筆。", en: "The standard order of regular script: 1 stroke." },
  strokeNow: { zh: "第 {k} 筆：{name}", en: "Stroke {k}: {name}" },
  playStrokes: { zh: "示範", en: "Play" },
  stopStrokes: { zh: "停", en: "Stop" },
  strokeBack: { zh: "退一筆", en: "One stroke back" },
  strokeOn: { zh: "進一筆", en: "One stroke on" },
  strokeNumbers: { zh: "標出筆號", en: "Number the strokes" },
});
