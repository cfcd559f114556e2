import type { PageProps } from "../router";

export default function Practice(_: PageProps) {
  return null;
}
