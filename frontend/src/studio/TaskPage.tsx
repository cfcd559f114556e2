import type { PageProps } from "../router";

export default function TaskPage(_: PageProps) {
  return null;
}
