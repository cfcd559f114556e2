// The pages by their paths, each loaded when it is first visited. Pages import the router and never this table.

import type { ComponentType } from "preact";
import type { PageProps } from "./router";

type Load = () => Promise<{ default: ComponentType<PageProps> }>;

/** Path patterns, `:name` for a parameter; the first that matches is shown. */
export const routes: [string, Load][] = [
  ["/", () => import("./gallery/Browse")],
  ["/works/:id", () => import("./gallery/WorkPage")],
  ["/collections", () => import("./gallery/Collections")],
  ["/tours", () => import("./gallery/Tours")],
  ["/tours/:id", () => import("./gallery/TourPage")],
  ["/add", () => import("./gallery/AddWork")],
  ["/studio", () => import("./studio/Choose")],
  ["/studio/:id", () => import("./studio/Write")],
  ["/attempts/:id", () => import("./studio/AttemptPage")],
  ["/practice", () => import("./studio/Practice")],
  ["/classes", () => import("./studio/Classes")],
  ["/classes/:id", () => import("./studio/ClassPage")],
  ["/tasks/:id", () => import("./studio/TaskPage")],
  ["/judge", () => import("./studio/Judge")],
  ["/login", () => import("./account/Login")],
  ["/join/:token", () => import("./account/Join")],
  ["/people", () => import("./account/People")],
  ["/account", () => import("./account/Password")],
];
