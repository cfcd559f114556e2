import type { PageProps } from "../router";

export default function AddWork(_: PageProps) {
  return null;
}
