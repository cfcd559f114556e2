import type { PageProps } from "../router";

export default function ClassPage(_: PageProps) {
  return null;
}
