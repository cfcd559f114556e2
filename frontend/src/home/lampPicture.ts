// One picture under a lamp, drawn by a small shader: the home page must not wait for the whole viewer.

import { paintRelit, loadCardImage } from "../gallery/relighting";
import { hasWebGL2 } from "../viewer/fallback";
import { loadPicture } from "../viewer/loading";
import { lampDirection, SHEEN } from "../viewer/shading";
import { lampFunctions } from "../viewer/shaders";

export type LampPicture = { light: (tilt: number, slant: number) => void; dispose: () => void };
type Files = { picture: string; normals: string; measured: boolean };

const vertex = /* glsl */ `#version 300 es
out vec2 at;
void main() { // one triangle that covers the picture
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  at = vec2(corner.x + 1.0, 1.0 - corner.y) / 2.0;
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

const fragment = /* glsl */ `#version 300 es
precision highp float;
uniform sampler2D albedo, normals;
uniform vec3 light;
uniform float sheen;
in vec2 at;
out vec4 colour;
${lampFunctions}
void main() {
  vec3 a = srgbToLinear(texture(albedo, at).rgb);
  vec3 n = decodeNormal(texture(normals, at).rgb);
  colour = vec4(linearToSrgb(warmLamp(a, n, light, vec3(0.0, 0.0, 1.0), sheen)), 1.0);
}`;

/** Loads both maps and draws them on the canvas at each call of `light`; on a 2-D canvas where WebGL2 is missing. */
export async function createLampPicture(canvas: HTMLCanvasElement, files: Files, signal: AbortSignal): Promise<LampPicture> {
  if (!hasWebGL2()) {
    const card = await loadCardImage(files.picture, files.normals);
    return { light: (tilt, slant) => paintRelit(canvas, card, tilt, slant, files.measured), dispose: () => undefined };
  }
  const [picture, normals] = await Promise.all([loadPicture(files.picture, signal), loadPicture(files.normals, signal)]);
  Object.assign(canvas, { width: picture.width, height: picture.height });
  const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: false });
  if (!gl) throw new Error("WebGL2 is missing");
  const program = link(gl);
  gl.useProgram(program);
  [picture, normals].forEach((image, unit) => bind(gl, unit, image));
  gl.uniform1i(gl.getUniformLocation(program, "albedo"), 0);
  gl.uniform1i(gl.getUniformLocation(program, "normals"), 1);
  gl.uniform1f(gl.getUniformLocation(program, "sheen"), files.measured ? 0 : SHEEN);
  const direction = gl.getUniformLocation(program, "light");
  return {
    light(tilt, slant) {
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.uniform3fv(direction, lampDirection(tilt, slant));
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    },
    dispose: () => gl.getExtension("WEBGL_lose_context")?.loseContext(),
  };
}

function link(gl: WebGL2RenderingContext): WebGLProgram {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]] as const) {
    const shader = gl.createShader(kind);
    if (!shader) throw new Error("the browser made no shader");
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? "the shader was refused");
  return program;
}

function bind(gl: WebGL2RenderingContext, unit: number, image: ImageBitmap): void {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
  image.close();
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
}
