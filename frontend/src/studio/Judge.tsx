import type { PageProps } from "../router";

export default function Judge(_: PageProps) {
  return null;
}
