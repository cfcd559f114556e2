// One's own account: a new password.

import { useState } from "preact/hooks";
import { post, refreshSession, session } from "../api";
import { t } from "../i18n";
import type { PageProps } from "../router";
import { NeedLogin } from "../studio/NeedLogin";
import { Field, Trouble } from "../ui";
import { NewPassword } from "./NewPassword";
import { flawOf } from "./password";
import { a } from "./say";
import "./account.css";

export default function Password(_: PageProps) {
  return (
    <NeedLogin why={a("accountNeeds")}>
      <Change />
    </NeedLogin>
  );
}

function Change() {
  const [old, setOld] = useState("");
  const [fresh, setFresh] = useState<[string, string]>(["", ""]);
  const [tried, setTried] = useState(false);
  const [state, setState] = useState<"" | "done" | { error: unknown }>("");
  const person = session.value!.person!;
  const change = async (event: Event) => {
    event.preventDefault();
    setTried(true);
    if (flawOf(...fresh, person.name)) return;
    try {
      await post("/api/password", { old, new: fresh[0] });
      await refreshSession();
      setState("done");
      setOld("");
      setFresh(["", ""]);
      setTried(false);
    } catch (error) {
      setState({ error });
    }
  };
  return (
    <form class="account panel" noValidate onSubmit={change}>
      <h1>{a("accountTitle")}</h1>
      <p>
        {person.name} · {a(`role_${person.role}`)}
      </p>
      <h2>{a("changePassword")}</h2>
      <input type="text" autocomplete="username" value={person.name} readOnly hidden />
      <Field label={a("oldPassword")}>
        <input type="password" autocomplete="current-password" required value={old} onInput={(event) => setOld(event.currentTarget.value)} />
      </Field>
      <NewPassword password={fresh[0]} again={fresh[1]} name={person.name} tried={tried} onChange={(...both) => (setFresh(both), setState(""))} />
      {typeof state === "object" && <Trouble error={state.error} />}
      <p class="row">
        <button type="submit" disabled={!old || !fresh[0]}>
          {t("save")}
        </button>
        <span role="status">{state === "done" ? a("changed") : ""}</span>
      </p>
      <p class="note">{a("changeNote")}</p>
    </form>
  );
}
