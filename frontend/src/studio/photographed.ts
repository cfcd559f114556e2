// What the service says of a photograph: whether it is a practice sheet, where the printed cell is, and the cell without perspective.

import { post, postForPicture } from "../api";
import { type Corners, cornersText } from "./corners";

type Seen = { sheet: boolean; cell: [number, number][] | null };

function form(picture: Blob, corners: Corners | null): FormData {
  const sent = new FormData();
  sent.set("picture", picture, "photo.jpg");
  if (corners) sent.set("corners", cornersText(corners));
  return sent;
}

/** Whether a photograph is of a practice sheet, and the corners of the printed cell near some; around: they are around the writing. */
export async function lookAt(picture: Blob, near: Corners | null, around: boolean): Promise<{ sheet: boolean; cell: Corners | null }> {
  const sent = form(picture, near);
  if (around) sent.set("around", "true");
  const seen = await post<Seen>("api/photographs", sent);
  return { sheet: seen.sheet, cell: seen.cell as unknown as Corners | null };
}

/** The cell between four corners as a square picture. */
export const flattenCell = (picture: Blob, corners: Corners): Promise<Blob> => postForPicture("api/photographs/cell", form(picture, corners));
