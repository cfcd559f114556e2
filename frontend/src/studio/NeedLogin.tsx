// A page that is somebody's says so, and comes back after the login.

import type { ComponentChildren } from "preact";
import { session } from "../api";
import { t } from "../i18n";
import { Waiting } from "../ui";
import { loginLink } from "./login";
import { w } from "./say";
import "./studio.css";

type Props = { roles?: readonly string[]; why: string; children: ComponentChildren };

export function NeedLogin({ roles, why, children }: Props) {
  if (!session.value) return <Waiting />;
  const person = session.value.person;
  if (!person)
    return (
      <div class="need panel">
        <h1>{t("login")}</h1>
        <p>{why}</p>
        <p class="row">
          <a class="button" href={loginLink()}>
            {t("login")}
          </a>
          <a class="button quiet" href="#/studio">
            {w("toStudio")}
          </a>
        </p>
      </div>
    );
  if (roles && !roles.includes(person.role)) return <div class="trouble"><h1>{w("notYours")}</h1></div>;
  return <>{children}</>;
}
