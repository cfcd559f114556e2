import { useState } from "preact/hooks";
import { post, refreshSession, session } from "../api";
import { common } from "../i18n";
import { t } from "../i18n/account";
import { navigate, type PageProps } from "../router";
import { returnPath } from "./RequireLogin";
import { ErrorMessage, Field } from "../ui";
import "./account.css";

export default function LoginPage({ query }: PageProps) {
  const back = query.get("back");
  const [name, setName] = useState("");
  const [password, setPassword] = useState("");
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const login = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    try {
      await post("api/login", { name, password });
      await refreshSession();
      navigate(returnPath(back));
    } catch (reason) {
      setError(reason);
      setBusy(false);
    }
  };
  const person = session.value?.person;
  return (
    <form class="account panel" onSubmit={login}>
      <h1>{common("login")}</h1>
      {person && (
        <p>
          {t("already", { name: person.name })} <a href={`#${returnPath(back)}`}>{t("goOn")}</a>
        </p>
      )}
      {back && !person && <p class="note">{t("returns")}</p>}
      {session.value?.owner_exists === false && <p class="trouble">{t("noOwner")}</p>}
      <Field label={t("name")}>
        <input name="username" autocomplete="username" required maxLength={80} value={name} onInput={(event) => setName(event.currentTarget.value)} />
      </Field>
      <Field label={t("password")}>
        <input
          name="password" type="password" autocomplete="current-password" required value={password}
          onInput={(event) => setPassword(event.currentTarget.value)}
        />
      </Field>
      {error !== null && <ErrorMessage error={error} />}
      <p class="row">
        <button type="submit" disabled={busy}>
          {common("login")}
        </button>
        <a class="button quiet" href="#/studio">
          {t("asVisitor")}
        </a>
      </p>
      <p class="note">{t("noLogin")}</p>
    </form>
  );
}
