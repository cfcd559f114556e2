import type { PageProps } from "../router";

export default function Classes(_: PageProps) {
  return null;
}
