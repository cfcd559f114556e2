// All accounts, for the owner.

import { useState } from "preact/hooks";
import { get, patch, session } from "../api";
import { t } from "../i18n/account";
import type { PageProps } from "../router";
import type { Role } from "../types";
import { RequireLogin } from "./RequireLogin";
import { ErrorMessage, ErrorPage, Field, Loading, useLoaded } from "../ui";
import { InvitationLink } from "./InvitationLink";
import "./account.css";

type Account = { id: string; name: string; role: Role; active: boolean };
const ROLES: Role[] = ["pupil", "teacher", "owner"];

export default function PeoplePage(_: PageProps) {
  return (
    <RequireLogin roles={["owner"]} reason={t("peopleNeeds")}>
      <PeopleTable />
    </RequireLogin>
  );
}

function PeopleTable() {
  const loaded = useLoaded((signal) => get<Account[]>("api/people", signal), "people");
  const [error, setError] = useState<unknown>(null);
  const change = (id: string, part: Partial<Account>) =>
    patch(`api/people/${id}`, part).then(
      () => (setError(null), loaded.retry()),
      (reason: unknown) => (setError(reason), loaded.retry()),
    );
  if (loaded.error) return <ErrorPage error={loaded.error} retry={loaded.retry} />;
  if (!loaded.value) return <Loading />;
  return (
    <div class="people">
      <h1>{t("peopleTitle")}</h1>
      {error !== null && <ErrorMessage error={error} />}
      <section class="panel">
        <div class="scroll" tabIndex={0} role="region" aria-label={t("peopleTitle")}>
          <table>
            <thead>
              <tr>
                <th scope="col">{t("name")}</th>
                <th scope="col">{t("role")}</th>
                <th scope="col">{t("state")}</th>
              </tr>
            </thead>
            <tbody>
              {loaded.value.map((one) => (
                <tr key={one.id} class={one.active ? "" : "away"}>
                  <th scope="row">
                    {one.name}
                    {one.id === session.value?.person?.id && <small class="note"> {t("you")}</small>}
                  </th>
                  <td>
                    <select value={one.role} aria-label={t("roleOf", { name: one.name })} onChange={(event) => change(one.id, { role: event.currentTarget.value as Role })}>
                      {ROLES.map((role) => (
                        <option key={role} value={role}>
                          {t(`role_${role}`)}
                        </option>
                      ))}
                    </select>
                  </td>
                  <td>
                    <button
                      type="button" class="quiet small" aria-label={t(one.active ? "deactivateOne" : "activateOne", { name: one.name })}
                      onClick={() => change(one.id, { active: !one.active })}
                    >
                      {t(one.active ? "deactivate" : "activate")}
                    </button>
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
        <p class="note">{t("deactivateNote")}</p>
      </section>
      <Invite />
    </div>
  );
}

function Invite() {
  const [role, setRole] = useState<Role>("teacher");
  return (
    <section class="panel">
      <h2>{t("invite")}</h2>
      <Field label={t("role")}>
        <select value={role} onChange={(event) => setRole(event.currentTarget.value as Role)}>
          {ROLES.map((one) => (
            <option key={one} value={one}>
              {t(`role_${one}`)}
            </option>
          ))}
        </select>
      </Field>
      <InvitationLink key={role} role={role} />
    </section>
  );
}
