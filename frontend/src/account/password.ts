// What a new password must be, said before the service has to.

export const SHORTEST = 8;
export const LONGEST = 200;

export type Flaw = "short" | "long" | "differs" | "isName" | "sameLetter";

/** What is wrong with a new password; null when it will do. */
export function flawOf(password: string, again: string, name = ""): Flaw | null {
  if (password.length < SHORTEST) return "short";
  if (password.length > LONGEST) return "long";
  if (name && password.toLowerCase() === name.trim().toLowerCase()) return "isName";
  if (new Set(password).size === 1) return "sameLetter";
  return password === again ? null : "differs";
}
