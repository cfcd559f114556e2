import { useEffect, useState } from "preact/hooks";
import type { ComponentType } from "preact";
import { get, post, refreshSession, session } from "./api";
import { common, language } from "./i18n";
import { kiosk, watchScreen } from "./kiosk";
import { matchPath, navigate, type PageProps, route } from "./router";
import { Foot } from "./home/Foot";
import { routes } from "./routes";
import type { Exhibition } from "./types";
import { ErrorPage, Loading } from "./ui";

type PageState = { Page: ComponentType<PageProps>; path: string } | { error: unknown; path: string };

export function App() {
  const { path, query } = route.value;
  const [pageState, setPageState] = useState<PageState | null>(null);
  const matched = routes.map(([pattern, load]) => ({ pattern, load, params: matchPath(pattern, path) })).find((r) => r.params);
  useEffect(() => {
    let current = true;
    if (matched) {
      matched.load().then(
        (module) => current && setPageState({ Page: module.default, path: matched.pattern }),
        (error: unknown) => current && setPageState({ error, path: matched.pattern }),
      );
    }
    return () => {
      current = false;
    };
  }, [matched?.pattern]);
  useEffect(() => watchScreen(() => void playTour()), []);
  return (
    <>
      <a class="skip" href="#main" onClick={toMain}>
        {common("skip")}
      </a>
      {kiosk.value ? <KioskBar path={path} home={kiosk.value.path} /> : <Header path={path} />}
      <main id="main" tabIndex={-1}>
        {!matched ? (
          <div class="trouble">
            <h1>{common("nothere")}</h1>
            <p>
              <a href="#/gallery">{common("home")}</a>
            </p>
          </div>
        ) : !pageState || pageState.path !== matched.pattern ? (
          <Loading />
        ) : "error" in pageState ? (
          <ErrorPage error={pageState.error} />
        ) : (
          <pageState.Page key={path} params={matched.params ?? {}} query={query} />
        )}
      </main>
      {!kiosk.value && <Foot />}
    </>
  );
}

// The hash is the route, so a plain link to #main would leave the page.
function toMain(event: Event): void {
  event.preventDefault();
  document.getElementById("main")?.focus();
}

function Header({ path }: { path: string }) {
  const person = session.value?.person ?? null;
  const links: [string, Parameters<typeof common>[0], boolean][] = [
    ["/gallery", "gallery", true],
    ["/collections", "collections", true],
    ["/tours", "tours", true],
    ["/studio", "studio", true],
    ["/practice", "practice", person !== null],
    ["/classes", "classes", person !== null],
    ["/judge", "judge", person !== null],
    ["/people", "people", person?.role === "owner"],
  ];
  return (
    <header class="top">
      <a class="brand" href="#/">
        <img src="seal.svg" alt="" width="28" height="28" />
        <span>入木</span> <small>rumu</small>
      </a>
      <nav aria-label={common("menu")}>
        {links
          .filter(([, , allowed]) => allowed)
          .map(([href, name]) => (
            <a key={href} href={`#${href}`} aria-current={path === href ? "page" : isWithin(path, href) ? "true" : undefined}>
              {common(name)}
            </a>
          ))}
      </nav>
      <div class="top-end">
        <LanguageButton />
        {person ? (
          <>
            <a href="#/account">{person.name}</a>
            <button type="button" class="quiet" onClick={logout}>
              {common("logout")}
            </button>
          </>
        ) : (
          <a href="#/login">{common("login")}</a>
        )}
      </div>
    </header>
  );
}

function LanguageButton() {
  return (
    <button
      type="button"
      class="quiet"
      lang={language.value === "zh" ? "en" : "zh-Hant"}
      onClick={() => (language.value = language.value === "zh" ? "en" : "zh")}
    >
      {common("language")}
    </button>
  );
}

/** What a screen in an exhibition has instead of the menu. */
function KioskBar({ path, home }: { path: string; home: string }) {
  return (
    <header class="top">
      {path !== home && <a class="button quiet" href={`#${home}`}>{common("backToExhibition")}</a>}
      <div class="top-end"><LanguageButton /></div>
    </header>
  );
}

/** Shows the tour of the exhibition by itself, where it has one. */
async function playTour(): Promise<void> {
  const id = kiosk.value?.path.split("/").at(-1);
  const shown = id ? await get<Exhibition>(`api/collections/${id}`).catch(() => null) : null;
  if (shown?.tour && kiosk.value) navigate(`/tours/${encodeURIComponent(shown.tour.id)}?play=1`);
}

/** Whether a page belongs to a menu entry: a work to the gallery; a page to write on, or a sheet of paper, to the studio. */
const isWithin = (path: string, href: string): boolean =>
  href === "/gallery" ? path.startsWith("/works/") : path.startsWith(`${href}/`) || (href === "/studio" && /^\/sheets(\/|$)/.test(path));

async function logout(): Promise<void> {
  await post("api/logout");
  await refreshSession();
  navigate("/");
}
