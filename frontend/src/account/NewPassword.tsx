// The fields for a new password, entered twice, and the rules for it, which the service checks too.

import { t } from "../i18n/account";
import { Field } from "../ui";

type Props = { password: string; repeated: string; name?: string; submitted: boolean; onChange: (password: string, repeated: string) => void };

export function NewPassword({ password, repeated, name = "", submitted, onChange }: Props) {
  const problem = passwordProblem(password, repeated, name);
  const visible = problem && (submitted || (problem === "differs" && repeated.length > 0));
  return (
    <>
      <Field label={t("newPassword")} hint={t("rules", { shortest: MIN_LENGTH })}>
        <input
          type="password" autocomplete="new-password" required minLength={MIN_LENGTH} maxLength={MAX_LENGTH} value={password}
          aria-invalid={Boolean(visible)} onInput={(event) => onChange(event.currentTarget.value, repeated)}
        />
      </Field>
      <Field label={t("passwordAgain")}>
        <input
          type="password" autocomplete="new-password" required maxLength={MAX_LENGTH} value={repeated} aria-invalid={Boolean(visible)}
          onInput={(event) => onChange(password, event.currentTarget.value)}
        />
      </Field>
      <p class="flaw" role="status">
        {visible ? t(problem, { shortest: MIN_LENGTH }) : ""}
      </p>
    </>
  );
}

const MIN_LENGTH = 8;
const MAX_LENGTH = 200;

type PasswordProblem = "short" | "long" | "differs" | "isName" | "sameLetter";

/** What is wrong with a new password, or null. */
export function passwordProblem(password: string, repeated: string, name = ""): PasswordProblem | null {
  if (password.length < MIN_LENGTH) return "short";
  if (password.length > MAX_LENGTH) return "long";
  if (name && password.toLowerCase() === name.trim().toLowerCase()) return "isName";
  if (new Set(password).size === 1) return "sameLetter";
  return password === repeated ? null : "differs";
}
