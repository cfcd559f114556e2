import { words } from "../i18n";
import { studio } from "../i18n/studio";

export const w = words(studio);
