import type { PageProps } from "../router";

export default function Choose(_: PageProps) {
  return null;
}
