// The foot of every page: what this is, what a mark means, where heights come from, licences.

import { t } from "../i18n/home";
import "./foot.css";

const PARTS: [part: string, title: "aboutMarks" | "aboutHeights" | "aboutLicences"][] = [
  ["marks", "aboutMarks"],
  ["heights", "aboutHeights"],
  ["licences", "aboutLicences"],
];

export function Foot() {
  return (
    <footer class="foot">
      <a href="#/about">{t("about")}</a>
      {PARTS.map(([part, name]) => <a key={part} href={`#/about?part=${part}`}>{t(name)}</a>)}
    </footer>
  );
}
