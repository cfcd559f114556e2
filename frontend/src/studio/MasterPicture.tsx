// The master as large as there is room, its thumbnail until it has come.

import { get } from "../api";
import type { Work, WorkCard } from "../types";
import { useLoaded } from "../ui";

export function MasterPicture({ work, alt }: { work: WorkCard; alt: string }) {
  const found = useLoaded((signal) => get<Work>(`/api/works/${encodeURIComponent(work.id)}`, signal), work.id);
  return <img class="sheet-picture" src={found.value?.files.picture ?? work.thumb} alt={alt} />;
}
