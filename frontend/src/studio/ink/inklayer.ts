// A picture -> its ink alone, in one colour, as a canvas that can be laid on anything.

/** ink: what is dark in a picture, or white in a mask. colour: of the result. side: longest side in pixels. */
export async function inkLayer(
  source: string | Blob, options: { ink: "dark" | "white"; colour: string; side?: number },
): Promise<HTMLCanvasElement> {
  const image = await loaded(source);
  const shrink = Math.min(1, (options.side ?? 768) / Math.max(image.naturalWidth, image.naturalHeight));
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(1, Math.round(image.naturalWidth * shrink));
  canvas.height = Math.max(1, Math.round(image.naturalHeight * shrink));
  const context = canvas.getContext("2d", { willReadFrequently: true })!;
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  const pixels = context.getImageData(0, 0, canvas.width, canvas.height);
  const value = (options.ink === "white" ? (v: number) => v : darkness(pixels.data));
  for (let k = 0; k < pixels.data.length; k += 4) {
    const light = 0.299 * pixels.data[k]! + 0.587 * pixels.data[k + 1]! + 0.114 * pixels.data[k + 2]!;
    pixels.data[k + 3] = value(light);
  }
  context.putImageData(pixels, 0, 0);
  context.globalCompositeOperation = "source-in";
  context.fillStyle = options.colour;
  context.fillRect(0, 0, canvas.width, canvas.height);
  return canvas;
}

/** 0-255 lightness -> 0-255 ink: between the darkest and the palest hundredth, so that the grey of a sheet is no ink. */
function darkness(data: Uint8ClampedArray): (light: number) => number {
  const lights: number[] = [];
  for (let k = 0; k < data.length; k += 4 * 7) lights.push(data[k + 1]!);
  lights.sort((a, b) => a - b);
  const [low, high] = [lights[Math.floor(lights.length * 0.01)] ?? 0, lights[Math.floor(lights.length * 0.9)] ?? 255];
  const [from, to] = [low + 0.65 * (high - low), low + 0.35 * (high - low)];
  return (light) => 255 * Math.min(1, Math.max(0, (from - light) / Math.max(1, from - to)));
}

function loaded(source: string | Blob): Promise<HTMLImageElement> {
  const url = typeof source === "string" ? source : URL.createObjectURL(source);
  return new Promise((done, fail) => {
    const image = new Image();
    image.onload = () => done(image);
    image.onerror = () => fail(new Error("expected a picture, got none"));
    image.src = url;
  }).finally(() => typeof source === "string" || setTimeout(() => URL.revokeObjectURL(url), 0)) as Promise<HTMLImageElement>;
}
