import type { PageProps } from "../router";

export default function Collections(_: PageProps) {
  return null;
}
