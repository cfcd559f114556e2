// The download of a solid for a 3-D printer: how wide, on how thick a base, with the relief that is shown.

import { useState } from "preact/hooks";
import { t } from "../i18n/viewer";

const WIDTH = { min: 5, max: 2000 };
const BASE = { min: 0.2, max: 100, usual: 2 };

/** The URL of a solid. width, base: millimetres as typed; what is empty or out of range is left to the service. */
export function printUrl(url: string, { width, base, exaggeration }: { width: string; base: string; exaggeration: number }): string {
  const query = new URLSearchParams({ download: "1" });
  const within = (text: string, { min, max }: { min: number; max: number }) => text.trim() !== "" && Number(text) >= min && Number(text) <= max;
  if (within(width, WIDTH)) query.set("width", String(Number(width)));
  if (within(base, BASE) && Number(base) !== BASE.usual) query.set("base", String(Number(base)));
  const relief = Math.max(0.01, Number(exaggeration.toFixed(2)));
  if (relief !== 1) query.set("exaggeration", String(relief));
  return `${url}${url.includes("?") ? "&" : "?"}${query}`;
}

export function PrintForm({ url, exaggeration }: { url: string; exaggeration: number }) {
  const [width, setWidth] = useState("");
  const [base, setBase] = useState(String(BASE.usual));
  return (
    <div class="print-form">
      <a href={printUrl(url, { width, base, exaggeration })} rel="noopener" download="">{t("file_stl")}</a>
      <label>
        {t("printWidth")}
        <input type="number" name="width" inputMode="decimal" min={WIDTH.min} max={WIDTH.max} step="any" value={width} placeholder={t("printAuto")}
          onInput={(event) => setWidth(event.currentTarget.value)} />
      </label>
      <label>
        {t("printBase")}
        <input type="number" name="base" inputMode="decimal" min={BASE.min} max={BASE.max} step="any" value={base}
          onInput={(event) => setBase(event.currentTarget.value)} />
      </label>
    </div>
  );
}
