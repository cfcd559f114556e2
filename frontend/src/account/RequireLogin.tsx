// Shows a page only to people who are logged in; others see a link to the login, which leads back to the page.

import type { ComponentChildren } from "preact";
import { session } from "../api";
import { common } from "../i18n";
import { t } from "../i18n/studio";
import { Loading } from "../ui";
import "../studio/studio.css";

type Props = { roles?: readonly string[]; reason: string; children: ComponentChildren };

export function RequireLogin({ roles, reason, children }: Props) {
  if (!session.value) return <Loading />;
  const person = session.value.person;
  if (!person)
    return (
      <div class="need panel">
        <h1>{common("login")}</h1>
        <p>{reason}</p>
        <p class="row">
          <a class="button" href={loginLink()}>
            {common("login")}
          </a>
          <a class="button quiet" href="#/studio">
            {t("toStudio")}
          </a>
        </p>
      </div>
    );
  if (roles && !roles.includes(person.role)) return <div class="trouble"><h1>{t("notYours")}</h1></div>;
  return <>{children}</>;
}

/** A link to the login page that returns to the current page. */
export const loginLink = (): string => `#/login?back=${encodeURIComponent(location.hash.replace(/^#/, "") || "/")}`;

/** Where to go after a login: a path of this site, never an address elsewhere. */
export const returnPath = (back: string | null): string => (back && /^\/(?!\/)/.test(back) ? back : "/");
