import type { PageProps } from "../router";

export default function WorkPage(_: PageProps) {
  return null;
}
