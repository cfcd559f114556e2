// The script of the one-file page, which contains the viewer's data and needs nothing else.

import "../src/style/tokens.css";
import "../src/style/base.css";
import { render } from "preact";
import { jsx } from "preact/jsx-runtime";
import type { Viewer } from "../src/viewer/types";
import { OnePage, type PageFacts } from "./OnePage";

let resolveViewer: (viewer: Viewer) => void;
/** Resolves to the viewer once it is ready, for scripts that control the page. */
export const viewer: Promise<Viewer> = new Promise((resolve) => (resolveViewer = resolve));

const data = document.getElementById("rumu-work")?.textContent;
const root = document.getElementById("app") ?? document.body.appendChild(document.createElement("div"));
if (data) render(jsx(OnePage, { facts: JSON.parse(data) as PageFacts, onViewer: (ready: Viewer | null) => ready && resolveViewer(ready) }), root);
