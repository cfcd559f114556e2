// The script of the one-file page: the facts lie in the page, the viewer shows them, and nothing else is needed.

import "../src/style/tokens.css";
import "../src/style/base.css";
import { render } from "preact";
import { jsx } from "preact/jsx-runtime";
import type { Viewer } from "../src/viewer/types";
import { OnePage, type PageFacts } from "./OnePage";

let meet: (viewer: Viewer) => void;
/** The viewer as soon as it stands: for scripts that drive the page. */
export const viewer: Promise<Viewer> = new Promise((resolve) => (meet = resolve));

const told = document.getElementById("rumu-work")?.textContent;
const root = document.getElementById("app") ?? document.body.appendChild(document.createElement("div"));
if (told) render(jsx(OnePage, { facts: JSON.parse(told) as PageFacts, onViewer: (found: Viewer | null) => found && meet(found) }), root);
