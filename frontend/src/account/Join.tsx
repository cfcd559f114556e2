// A login out of an invitation.

import { useState } from "preact/hooks";
import { get, post, refreshSession } from "../api";
import { t } from "../i18n";
import { go, type PageProps } from "../router";
import type { Role } from "../types";
import { Field, Trouble, useLoaded, Waiting } from "../ui";
import { NewPassword } from "./NewPassword";
import { flawOf } from "./password";
import { a } from "./say";
import "./account.css";

type Invitation = { role: Role; class: { id: string; name: string } | null };

export default function Join({ params }: PageProps) {
  const url = `/api/invitations/${encodeURIComponent(params["token"] ?? "")}`;
  const found = useLoaded((signal) => get<Invitation>(url, signal), url);
  if (found.error)
    return (
      <div class="account panel">
        <h1>{a("joinTitle")}</h1>
        <Trouble error={found.error} />
        <p class="note">{a("linkDead")}</p>
        <a class="button quiet" href="#/login">
          {t("login")}
        </a>
      </div>
    );
  return found.value ? <JoinForm url={url} invitation={found.value} /> : <Waiting />;
}

function JoinForm({ url, invitation }: { url: string; invitation: Invitation }) {
  const [name, setName] = useState("");
  const [password, setPassword] = useState<[string, string]>(["", ""]);
  const [tried, setTried] = useState(false);
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const to = invitation.class?.name;
  const join = async (event: Event) => {
    event.preventDefault();
    setTried(true);
    if (flawOf(...password, name)) return;
    setBusy(true);
    try {
      await post(url, { name, password: password[0] });
      await refreshSession();
      go(invitation.role === "owner" ? "/people" : invitation.role === "teacher" ? "/classes" : to ? "/classes" : "/studio");
    } catch (why) {
      setError(why);
      setBusy(false);
    }
  };
  return (
    <form class="account panel" noValidate onSubmit={join}>
      <h1>{a("joinTitle")}</h1>
      <p>{to ? a("joinClass", { name: to }) : a(`joinAs_${invitation.role}`)}</p>
      <Field label={a("name")} hint={a("nameHint")}>
        <input autocomplete="username" required maxLength={80} value={name} onInput={(event) => setName(event.currentTarget.value)} />
      </Field>
      <NewPassword password={password[0]} again={password[1]} name={name} tried={tried} onChange={(...both) => setPassword(both)} />
      {error !== null && <Trouble error={error} />}
      <button type="submit" disabled={busy || !name.trim()}>
        {a("join")}
      </button>
      {to && <p class="note">{a("joinAgain")}</p>}
    </form>
  );
}
