import type { PageProps } from "../router";

export default function Login(_: PageProps) {
  return null;
}
