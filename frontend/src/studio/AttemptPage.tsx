import type { PageProps } from "../router";

export default function AttemptPage(_: PageProps) {
  return null;
}
