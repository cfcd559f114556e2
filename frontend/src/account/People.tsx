import type { PageProps } from "../router";

export default function People(_: PageProps) {
  return null;
}
