import type { ComponentChildren } from "preact";
import { get } from "../api";
import { localize } from "../i18n";
import { t } from "../i18n/gallery";
import type { Facets, Work } from "../types";
import { Field, useLoaded } from "../ui";
import { scriptName, SCRIPTS } from "./labels";
import { licenceField, licenceName } from "./licences";

const LICENCES = ["CC0-1.0", "CC-BY-4.0", "CC-BY-SA-4.0", "public domain", "公有領域"];

type Props = { work?: Work; spacing: boolean; children?: ComponentChildren };

/** The form fields for a work's metadata. `spacing`: ask for the size of a pixel, which a capture under several lamps brings itself. */
export function FactFields({ work, spacing, children }: Props) {
  return (
    <div class="fact-fields">
      <TextField name="title_zh" label={t("titleZh")} lang="zh-Hant" value={work?.title.zh} />
      <TextField name="title_en" label={t("titleEn")} lang="en" value={work?.title.en} />
      <TextField name="character" label={t("character")} lang="zh-Hant" value={work?.character} maxLength={16} />
      <Field label={t("script")}>
        <select name="script">
          {["", ...SCRIPTS].map((name) => <option key={name} value={name} selected={name === (work?.script ?? "")}>{name ? scriptName(name) : "—"}</option>)}
        </select>
      </Field>
      <TextField name="hand_zh" label={t("handZh")} lang="zh-Hant" value={work?.hand.zh} />
      <TextField name="hand_en" label={t("handEn")} lang="en" value={work?.hand.en} />
      <TextField name="period_zh" label={t("periodZh")} lang="zh-Hant" value={work?.period.zh} />
      <TextField name="period_en" label={t("periodEn")} lang="en" value={work?.period.en} />
      <TextAreaField name="material_zh" label={t("materialZh")} lang="zh-Hant" value={work?.material.zh} />
      <TextAreaField name="material_en" label={t("materialEn")} lang="en" value={work?.material.en} />
      <Dynasty value={work?.dynasty} />
      <Field label={t("licence")} hint={t("licenceHint")}>
        <input name="licence" list="licences" maxLength={200} required={work?.licence !== "none stated"}
          defaultValue={licenceField(work?.licence ?? "")} placeholder={work?.licence === "none stated" ? licenceName(work.licence) : ""} />
      </Field>
      <TextAreaField name="source" label={t("source")} hint={t("sourceHint")} value={work?.source} />
      <TextAreaField name="attribution" label={t("attribution")} value={work?.attribution} />
      {spacing && <Spacing value={work?.spacing ?? null} />}
      {children}
      <datalist id="licences">{LICENCES.map((name) => <option key={name} value={name} />)}</datalist>
    </div>
  );
}

type TextFieldProps = { name: string; label: string; lang?: string; value?: string | undefined; hint?: string; maxLength?: number };

function TextField({ name, label, lang, value = "", maxLength = 200 }: TextFieldProps) {
  return <Field label={label}><input name={name} lang={lang} maxLength={maxLength} defaultValue={value} /></Field>;
}

function TextAreaField({ name, label, lang, value = "", hint = "", maxLength = 8000 }: TextFieldProps) {
  return <Field label={label} hint={hint}><textarea name={name} lang={lang} rows={2} maxLength={maxLength} defaultValue={value} /></Field>;
}

function Spacing({ value }: { value: number | null }) {
  return (
    <Field label={t("spacing")} hint={t("spacingHint")}>
      <input name="spacing" type="number" min="0.000001" max="1000" step="any" defaultValue={value === null ? "" : String(value)} />
    </Field>
  );
}

function Dynasty({ value = "" }: { value?: string | undefined }) {
  const facets = useLoaded((signal) => get<Facets>("api/facets", signal), "all");
  return (
    <Field label={t("dynasty")}>
      <input name="dynasty" list="dynasties" maxLength={40} defaultValue={value} />
      <datalist id="dynasties">{(facets.value?.dynasty ?? []).filter((f) => f.value).map((f) => <option key={f.value} value={f.value}>{localize(f)}</option>)}</datalist>
    </Field>
  );
}
