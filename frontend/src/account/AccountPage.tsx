// A person's own account: change the password, end the sessions on all devices.

import { useState } from "preact/hooks";
import { post, refreshSession, session } from "../api";
import { common } from "../i18n";
import { t } from "../i18n/account";
import { navigate, type PageProps } from "../router";
import { RequireLogin } from "./RequireLogin";
import { ErrorMessage, Facts, Field } from "../ui";
import { NewPassword, passwordProblem } from "./NewPassword";
import "./account.css";

export default function AccountPage(_: PageProps) {
  return (
    <RequireLogin reason={t("accountNeeds")}>
      <ChangePassword />
      <LogOutEverywhere />
    </RequireLogin>
  );
}

function ChangePassword() {
  const [current, setCurrent] = useState("");
  const [next, setNext] = useState<[string, string]>(["", ""]);
  const [submitted, setSubmitted] = useState(false);
  const [state, setState] = useState<"" | "done" | { error: unknown }>("");
  const person = session.value!.person!;
  const change = async (event: Event) => {
    event.preventDefault();
    setSubmitted(true);
    if (passwordProblem(...next, person.name)) return;
    try {
      await post("api/password", { old: current, new: next[0] });
      await refreshSession();
      setState("done");
      setCurrent("");
      setNext(["", ""]);
      setSubmitted(false);
    } catch (error) {
      setState({ error });
    }
  };
  return (
    <form class="account panel" noValidate onSubmit={change}>
      <h1>{t("accountTitle")}</h1>
      <p>
        <Facts items={[person.name, t(`role_${person.role}`)]} />
      </p>
      <h2>{t("changePassword")}</h2>
      <input type="text" autocomplete="username" value={person.name} readOnly hidden />
      <Field label={t("oldPassword")}>
        <input type="password" autocomplete="current-password" required value={current} onInput={(event) => setCurrent(event.currentTarget.value)} />
      </Field>
      <NewPassword password={next[0]} repeated={next[1]} name={person.name} submitted={submitted} onChange={(...both) => (setNext(both), setState(""))} />
      {typeof state === "object" && <ErrorMessage error={state.error} />}
      <p class="row">
        <button type="submit" disabled={!current || !next[0]}>
          {common("save")}
        </button>
        <span role="status">{state === "done" ? t("changed") : ""}</span>
      </p>
      <p class="note">{t("changeNote")}</p>
    </form>
  );
}

function LogOutEverywhere() {
  const [error, setError] = useState<unknown>(null);
  const end = () =>
    post("api/logout?everywhere=true")
      .then(refreshSession)
      .then(() => navigate("/login"), setError);
  return (
    <section class="account panel">
      <h2>{t("everywhere")}</h2>
      <p class="note">{t("everywhereNote")}</p>
      {error !== null && <ErrorMessage error={error} />}
      <p class="row">
        <button type="button" class="quiet" onClick={end}>
          {t("everywhere")}
        </button>
      </p>
    </section>
  );
}
