// A new password, twice, with its rules beside it.

import { Field } from "../ui";
import { flawOf, LONGEST, SHORTEST } from "./password";
import { a } from "./say";

type Props = { password: string; again: string; name?: string; tried: boolean; onChange: (password: string, again: string) => void };

export function NewPassword({ password, again, name = "", tried, onChange }: Props) {
  const flaw = flawOf(password, again, name);
  const said = flaw && (tried || (flaw === "differs" && again.length > 0));
  return (
    <>
      <Field label={a("newPassword")} hint={a("rules", { shortest: SHORTEST })}>
        <input
          type="password" autocomplete="new-password" required minLength={SHORTEST} maxLength={LONGEST} value={password}
          aria-invalid={Boolean(said)} onInput={(event) => onChange(event.currentTarget.value, again)}
        />
      </Field>
      <Field label={a("passwordAgain")}>
        <input
          type="password" autocomplete="new-password" required maxLength={LONGEST} value={again} aria-invalid={Boolean(said)}
          onInput={(event) => onChange(password, event.currentTarget.value)}
        />
      </Field>
      <p class="flaw" role="status">
        {said ? a(flaw, { shortest: SHORTEST }) : ""}
      </p>
    </>
  );
}
