import { useEffect, useState } from "preact/hooks";
import type { ComponentType } from "preact";
import { post, refreshSession, session } from "./api";
import { language, t } from "./i18n";
import { go, match, place, type PageProps } from "./router";
import { routes } from "./routes";
import { PageTrouble, Waiting } from "./ui";

type Shown = { Page: ComponentType<PageProps>; path: string } | { error: unknown; path: string };

export function App() {
  const { path, query } = place.value;
  const [shown, setShown] = useState<Shown | null>(null);
  const found = routes.map(([pattern, load]) => ({ pattern, load, params: match(pattern, path) })).find((r) => r.params);
  useEffect(() => {
    let current = true;
    if (found) {
      found.load().then(
        (module) => current && setShown({ Page: module.default, path: found.pattern }),
        (error: unknown) => current && setShown({ error, path: found.pattern }),
      );
    }
    return () => {
      current = false;
    };
  }, [found?.pattern]);
  return (
    <>
      <a class="skip" href="#main" onClick={toMain}>
        {t("skip")}
      </a>
      <Header path={path} />
      <main id="main" tabIndex={-1}>
        {!found ? (
          <div class="trouble">
            <h1>{t("nothere")}</h1>
            <p>
              <a href="#/">{t("home")}</a>
            </p>
          </div>
        ) : !shown || shown.path !== found.pattern ? (
          <Waiting />
        ) : "error" in shown ? (
          <PageTrouble error={shown.error} />
        ) : (
          <shown.Page key={path} params={found.params ?? {}} query={query} />
        )}
      </main>
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
  const links: [string, Parameters<typeof t>[0], boolean][] = [
    ["/", "gallery", true],
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
        <img src="/seal.svg" alt="" width="28" height="28" />
        <span>入木</span> <small>rumu</small>
      </a>
      <nav aria-label={t("menu")}>
        {links
          .filter(([, , allowed]) => allowed)
          .map(([href, name]) => (
            <a key={href} href={`#${href}`} aria-current={path === href ? "page" : within(path, href) ? "true" : undefined}>
              {t(name)}
            </a>
          ))}
      </nav>
      <div class="top-end">
        <button
          type="button"
          class="quiet"
          lang={language.value === "zh" ? "en" : "zh-Hant"}
          onClick={() => (language.value = language.value === "zh" ? "en" : "zh")}
        >
          {t("language")}
        </button>
        {person ? (
          <>
            <a href="#/account">{person.name}</a>
            <button type="button" class="quiet" onClick={logout}>
              {t("logout")}
            </button>
          </>
        ) : (
          <a href="#/login">{t("login")}</a>
        )}
      </div>
    </header>
  );
}

/** A page that lies below one of the menu: a work in the gallery, a sheet in the studio. */
const within = (path: string, href: string): boolean => (href === "/" ? path.startsWith("/works/") : path.startsWith(`${href}/`));

async function logout(): Promise<void> {
  await post("/api/logout");
  await refreshSession();
  go("/");
}
