// Everybody with a login, for the owner.

import { useState } from "preact/hooks";
import { get, patch, session } from "../api";
import type { PageProps } from "../router";
import type { Role } from "../types";
import { NeedLogin } from "../studio/NeedLogin";
import { Field, PageTrouble, Trouble, useLoaded, Waiting } from "../ui";
import { InvitationLink } from "./InvitationLink";
import { a } from "./say";
import "./account.css";

type Somebody = { id: string; name: string; role: Role; active: boolean };
const ROLES: Role[] = ["pupil", "teacher", "owner"];

export default function People(_: PageProps) {
  return (
    <NeedLogin roles={["owner"]} why={a("peopleNeeds")}>
      <Everybody />
    </NeedLogin>
  );
}

function Everybody() {
  const found = useLoaded((signal) => get<Somebody[]>("/api/people", signal), "people");
  const [error, setError] = useState<unknown>(null);
  const change = (id: string, part: Partial<Somebody>) =>
    patch(`/api/people/${id}`, part).then(
      () => (setError(null), found.again()),
      (why: unknown) => (setError(why), found.again()),
    );
  if (found.error) return <PageTrouble error={found.error} again={found.again} />;
  if (!found.value) return <Waiting />;
  return (
    <div class="people">
      <h1>{a("peopleTitle")}</h1>
      {error !== null && <Trouble error={error} />}
      <section class="panel">
        <div class="scroll" tabIndex={0} role="region" aria-label={a("peopleTitle")}>
          <table>
            <thead>
              <tr>
                <th scope="col">{a("name")}</th>
                <th scope="col">{a("role")}</th>
                <th scope="col">{a("state")}</th>
              </tr>
            </thead>
            <tbody>
              {found.value.map((one) => (
                <tr key={one.id} class={one.active ? "" : "away"}>
                  <th scope="row">
                    {one.name}
                    {one.id === session.value?.person?.id && <small class="note"> {a("you")}</small>}
                  </th>
                  <td>
                    <select value={one.role} aria-label={a("roleOf", { name: one.name })} onChange={(event) => change(one.id, { role: event.currentTarget.value as Role })}>
                      {ROLES.map((role) => (
                        <option key={role} value={role}>
                          {a(`role_${role}`)}
                        </option>
                      ))}
                    </select>
                  </td>
                  <td>
                    <button
                      type="button" class="quiet small" aria-label={a(one.active ? "deactivateOne" : "activateOne", { name: one.name })}
                      onClick={() => change(one.id, { active: !one.active })}
                    >
                      {a(one.active ? "deactivate" : "activate")}
                    </button>
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
        <p class="note">{a("deactivateNote")}</p>
      </section>
      <Invite />
    </div>
  );
}

function Invite() {
  const [role, setRole] = useState<Role>("teacher");
  return (
    <section class="panel">
      <h2>{a("invite")}</h2>
      <Field label={a("role")}>
        <select value={role} onChange={(event) => setRole(event.currentTarget.value as Role)}>
          {ROLES.map((one) => (
            <option key={one} value={one}>
              {a(`role_${one}`)}
            </option>
          ))}
        </select>
      </Field>
      <InvitationLink key={role} role={role} />
    </section>
  );
}
