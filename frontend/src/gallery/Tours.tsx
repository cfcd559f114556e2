import type { PageProps } from "../router";

export default function Tours(_: PageProps) {
  return null;
}
