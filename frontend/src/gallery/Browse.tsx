import type { PageProps } from "../router";

export default function Browse(_: PageProps) {
  return null;
}
