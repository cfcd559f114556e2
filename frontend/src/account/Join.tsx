import type { PageProps } from "../router";

export default function Join(_: PageProps) {
  return null;
}
