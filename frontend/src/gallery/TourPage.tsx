import type { PageProps } from "../router";

export default function TourPage(_: PageProps) {
  return null;
}
