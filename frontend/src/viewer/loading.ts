// Loads the viewer's files. Pictures are decoded without colour conversion, so that a texel has exactly the stored value.

import { ServiceError } from "../api";

/** The bytes at a URL, gunzipped if need be. data: URLs are decoded here, because a page opened from a disk may not fetch. */
async function loadBytes(url: string, signal?: AbortSignal): Promise<Uint8Array<ArrayBuffer>> {
  const data = url.startsWith("data:") ? fromData(url) : await fromNetwork(url, signal);
  return data[0] === 0x1f && data[1] === 0x8b ? unzip(data) : data;
}

export async function loadHeights(url: string, count: number, signal?: AbortSignal): Promise<Float32Array> {
  const data = await loadBytes(url, signal);
  if (data.byteLength !== count * 4) throw new Error(`expected ${count * 4} bytes of heights, got ${data.byteLength}`);
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  return Float32Array.from({ length: count }, (_, k) => view.getFloat32(k * 4, true));
}

/** A decoded picture, first row on top, with its stored values. */
export async function loadPicture(url: string, signal?: AbortSignal): Promise<ImageBitmap> {
  const blob = new Blob([await loadBytes(url, signal)]);
  return createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
}

function fromData(url: string): Uint8Array<ArrayBuffer> {
  const comma = url.indexOf(",");
  const body = url.slice(comma + 1);
  if (!url.slice(0, comma).endsWith(";base64")) return new TextEncoder().encode(decodeURIComponent(body));
  return Uint8Array.from(atob(body), (letter) => letter.charCodeAt(0));
}

async function fromNetwork(url: string, signal?: AbortSignal): Promise<Uint8Array<ArrayBuffer>> {
  const response = await fetch(url, { signal: signal ?? null, credentials: "same-origin" });
  if (!response.ok) {
    throw new ServiceError(response.status, "file", {
      zh: `讀不到檔案（${response.status}）。`,
      en: `A file could not be read (${response.status}).`,
    });
  }
  return new Uint8Array(await response.arrayBuffer());
}

async function unzip(packed: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
