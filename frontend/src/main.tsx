import { render } from "preact";
import { refreshSession } from "./api";
import { App } from "./app";
import "./style/tokens.css";
import "./style/base.css";

void refreshSession().catch(() => undefined); // the gallery needs no session; pages that do say so
const root = document.getElementById("app");
if (root) render(<App />, root);
