import { t, words } from "../i18n";
import { gallery } from "../i18n/gallery";

const g = words(gallery);

const SCRIPTS = ["seal", "clerical", "regular", "running", "cursive"] as const;

/** 楷書 or Regular; what is not one of the five stays as it is. */
export const scriptName = (script: string): string => {
  const known = SCRIPTS.find((name) => name === script);
  return known ? t(known) : script;
};

/** A licence as it was given; the service's "none stated" in the reader's words. */
export const licenceName = (licence: string): string => (licence === "none stated" ? g("noLicence") : licence);
