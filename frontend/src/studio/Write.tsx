import type { PageProps } from "../router";

export default function Write(_: PageProps) {
  return null;
}
