// A page that is somebody's says so, and comes back after the login.

import type { ComponentChildren } from "preact";
import { session } from "../api";
import { common } from "../i18n";
import { t } from "../i18n/studio";
import { Loading } from "../ui";
import "../studio/studio.css";

type Props = { roles?: readonly string[]; why: string; children: ComponentChildren };

export function RequireLogin({ roles, why, children }: Props) {
  if (!session.value) return <Loading />;
  const person = session.value.person;
  if (!person)
    return (
      <div class="need panel">
        <h1>{common("login")}</h1>
        <p>{why}</p>
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

/** Where somebody logs in, to come back to the present page. */
export const loginLink = (): string => `#/login?back=${encodeURIComponent(location.hash.replace(/^#/, "") || "/")}`;

/** Where to go after a login: a path of these pages, never another place. */
export const returnPath = (back: string | null): string => (back && /^\/(?!\/)/.test(back) ? back : "/");
