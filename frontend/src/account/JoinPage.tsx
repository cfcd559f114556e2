// Accepting an invitation: choose a name and a password.

import { useState } from "preact/hooks";
import { get, post, refreshSession } from "../api";
import { common } from "../i18n";
import { t } from "../i18n/account";
import { navigate, type PageProps } from "../router";
import type { Role } from "../types";
import { ErrorMessage, Field, Loading, useLoaded } from "../ui";
import { NewPassword, passwordProblem } from "./NewPassword";
import "./account.css";

type Invitation = { role: Role; class: { id: string; name: string } | null };

export default function JoinPage({ params }: PageProps) {
  const url = `api/invitations/${encodeURIComponent(params["token"] ?? "")}`;
  const loaded = useLoaded((signal) => get<Invitation>(url, signal), url);
  if (loaded.error)
    return (
      <div class="account panel">
        <h1>{t("joinTitle")}</h1>
        <ErrorMessage error={loaded.error} />
        <p class="note">{t("linkDead")}</p>
        <a class="button quiet" href="#/login">
          {common("login")}
        </a>
      </div>
    );
  return loaded.value ? <JoinForm url={url} invitation={loaded.value} /> : <Loading />;
}

/** Where a pupil begins: at the newest task of the class that is not over, else at the class, else in the studio. */
async function firstPage(classId: string | undefined): Promise<string> {
  if (!classId) return "/studio";
  try {
    const { tasks } = await get<{ tasks: { id: string; due: string | null }[] }>(`api/classes/${classId}`);
    return firstTask(tasks, new Date()) ?? `/classes/${classId}`;
  } catch {
    return "/classes"; // they have joined; only the list of tasks is missing
  }
}

/** The page of the first task that is not over; tasks: the newest first. */
export function firstTask(tasks: readonly { id: string; due: string | null }[], now: Date): string | null {
  const open = tasks.find((task) => !task.due || new Date(task.due) >= now);
  return open ? `/tasks/${open.id}` : null;
}

function JoinForm({ url, invitation }: { url: string; invitation: Invitation }) {
  const [name, setName] = useState("");
  const [password, setPassword] = useState<[string, string]>(["", ""]);
  const [submitted, setSubmitted] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const to = invitation.class?.name;
  const join = async (event: Event) => {
    event.preventDefault();
    setSubmitted(true);
    if (passwordProblem(...password, name)) return;
    setBusy(true);
    try {
      await post(url, { name, password: password[0] });
      await refreshSession();
      navigate(invitation.role === "owner" ? "/people" : invitation.role === "teacher" ? "/classes" : await firstPage(invitation.class?.id));
    } catch (reason) {
      setError(reason);
      setBusy(false);
    }
  };
  return (
    <form class="account panel" noValidate onSubmit={join}>
      <h1>{t("joinTitle")}</h1>
      <p>{to ? t("joinClass", { name: to }) : t(`joinAs_${invitation.role}`)}</p>
      <Field label={t("name")} hint={t("nameHint")}>
        <input autocomplete="username" required maxLength={80} value={name} onInput={(event) => setName(event.currentTarget.value)} />
      </Field>
      <NewPassword password={password[0]} repeated={password[1]} name={name} submitted={submitted} onChange={(...both) => setPassword(both)} />
      {error !== null && <ErrorMessage error={error} />}
      <button type="submit" disabled={busy || !name.trim()}>
        {t("join")}
      </button>
      {to && <p class="note">{t("joinAgain")}</p>}
    </form>
  );
}
