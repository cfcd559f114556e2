// The pages by their paths, each loaded when it is first visited. Pages import the router and never this table.

import type { ComponentType } from "preact";
import type { PageProps } from "./router";

type Load = () => Promise<{ default: ComponentType<PageProps> }>;

/** Path patterns, `:name` for a parameter; the first that matches is shown. */
export const routes: [string, Load][] = [
  ["/", () => import("./home/HomePage")],
  ["/about", () => import("./home/AboutPage")],
  ["/gallery", () => import("./gallery/GalleryPage")],
  ["/works/:id", () => import("./gallery/WorkPage")],
  ["/characters/:character", () => import("./gallery/GatherPage")],
  ["/collections", () => import("./gallery/CollectionsPage")],
  ["/collections/:id", () => import("./gallery/CollectionPage")],
  ["/tours", () => import("./gallery/ToursPage")],
  ["/tours/:id", () => import("./gallery/TourPage")],
  ["/add", () => import("./gallery/AddWorkPage")],
  ["/studio", () => import("./studio/ChooseMasterPage")],
  ["/studio/:id", () => import("./studio/WritePage")],
  ["/sheets/print", () => import("./sheets/PrintPage")],
  ["/sheets", () => import("./sheets/SendPage")],
  ["/sheets/:id", () => import("./sheets/MarksPage")],
  ["/attempts/:id", () => import("./studio/AttemptPage")],
  ["/practice", () => import("./studio/PracticePage")],
  ["/classes", () => import("./studio/ClassesPage")],
  ["/classes/:id", () => import("./studio/ClassPage")],
  ["/tasks/:id", () => import("./studio/TaskPage")],
  ["/judge", () => import("./studio/ComparePage")],
  ["/login", () => import("./account/LoginPage")],
  ["/join/:token", () => import("./account/JoinPage")],
  ["/people", () => import("./account/PeoplePage")],
  ["/account", () => import("./account/AccountPage")],
];
