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
      navigate(invitation.role === "owner" ? "/people" : invitation.role === "teacher" ? "/classes" : to ? "/classes" : "/studio");
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
