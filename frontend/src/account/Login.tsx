import { useState } from "preact/hooks";
import { post, refreshSession, session } from "../api";
import { t } from "../i18n";
import { go, type PageProps } from "../router";
import { wayBack } from "../studio/login";
import { Field, Trouble } from "../ui";
import { a } from "./say";
import "./account.css";

export default function Login({ query }: PageProps) {
  const back = query.get("back");
  const [name, setName] = useState("");
  const [password, setPassword] = useState("");
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  const login = async (event: Event) => {
    event.preventDefault();
    setBusy(true);
    try {
      await post("/api/login", { name, password });
      await refreshSession();
      go(wayBack(back));
    } catch (why) {
      setError(why);
      setBusy(false);
    }
  };
  const person = session.value?.person;
  return (
    <form class="account panel" onSubmit={login}>
      <h1>{t("login")}</h1>
      {person && (
        <p>
          {a("already", { name: person.name })} <a href={`#${wayBack(back)}`}>{a("goOn")}</a>
        </p>
      )}
      {back && !person && <p class="note">{a("returns")}</p>}
      {session.value?.owner_exists === false && <p class="trouble">{a("noOwner")}</p>}
      <Field label={a("name")}>
        <input name="username" autocomplete="username" required maxLength={80} value={name} onInput={(event) => setName(event.currentTarget.value)} />
      </Field>
      <Field label={a("password")}>
        <input
          name="password" type="password" autocomplete="current-password" required value={password}
          onInput={(event) => setPassword(event.currentTarget.value)}
        />
      </Field>
      {error !== null && <Trouble error={error} />}
      <p class="row">
        <button type="submit" disabled={busy}>
          {t("login")}
        </button>
        <a class="button quiet" href="#/studio">
          {a("asVisitor")}
        </a>
      </p>
      <p class="note">{a("noLogin")}</p>
    </form>
  );
}
