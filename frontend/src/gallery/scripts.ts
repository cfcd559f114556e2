import { t } from "../i18n";

const SCRIPTS = ["seal", "clerical", "regular", "running", "cursive"] as const;

/** 楷書 or Regular; what is not one of the five stays as it is. */
export const scriptName = (script: string): string => {
  const known = SCRIPTS.find((name) => name === script);
  return known ? t(known) : script;
};
