// The shaders. shading.ts has the same arithmetic, line for line; a test on a GPU compares both with rumu.

import { ANCHORS, WARM } from "./shading";

const sampling = /* glsl */ `
uniform vec4 known; // over what of the sheet the heights reach: left, top, width, height
vec2 inKnown(vec2 uv) {
  return (uv - known.xy) / known.zw;
}
float heightAt(highp sampler2D values, vec2 uv) {
  vec2 size = vec2(textureSize(values, 0));
  vec2 p = clamp(uv * size - 0.5, vec2(0.0), size - 1.0);
  vec2 base = floor(p);
  ivec2 c = ivec2(base);
  ivec2 d = min(c + 1, ivec2(size) - 1);
  float top = mix(texelFetch(values, c, 0).r, texelFetch(values, ivec2(d.x, c.y), 0).r, p.x - base.x);
  float bottom = mix(texelFetch(values, ivec2(c.x, d.y), 0).r, texelFetch(values, d, 0).r, p.x - base.x);
  return mix(top, bottom, p.y - base.y);
}`;

/** GLSL of the warm lamp: colours, normals, shading and sheen. */
export const lampFunctions = /* glsl */ `
const vec3 warm = vec3(${WARM.map((v) => v.toFixed(4)).join(", ")});
vec3 srgbToLinear(vec3 c) {
  return mix(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, vec3(lessThanEqual(c, vec3(0.04045))));
}
vec3 linearToSrgb(vec3 c) {
  return mix(1.055 * pow(max(c, 0.0), vec3(1.0 / 2.4)) - 0.055, c * 12.92, vec3(lessThanEqual(c, vec3(0.0031308))));
}
vec3 decodeNormal(vec3 c) {
  vec3 n = (c * 255.0 - 127.5) / 127.5;
  return n / max(length(n), 1e-6);
}
vec3 exaggerate(vec3 n, float k) {
  vec3 m = vec3(n.xy * k, n.z);
  return m / max(length(m), 1e-6);
}
float shading(vec3 n, vec3 l) {
  return max(dot(n, l), 0.0);
}
vec3 lambert(vec3 a, vec3 n, vec3 l) {
  return min(a * shading(n, l), 1.0);
}
float exposure(vec3 l) {
  return pow(max(l.z, 0.3), -0.7);
}
float inkSheen(vec3 a, vec3 n, vec3 l, vec3 toEye) {
  float dark = max(1.0 - dot(a, vec3(0.2126, 0.7152, 0.0722)), 0.0);
  vec3 halfway = l + toEye;
  float towards = max(dot(n, halfway) / max(length(halfway), 1e-6), 0.0);
  return dark * dark * pow(towards, 22.0) * min(shading(n, l) * 4.0, 1.0);
}
vec3 warmLamp(vec3 a, vec3 n, vec3 l, vec3 toEye, float sheen) {
  return min((a * shading(n, l) + inkSheen(a, n, l, toEye) * sheen) * exposure(l) * warm, 1.0);
}`;

export const vertex = /* glsl */ `
precision highp float;
precision highp sampler2D;
in vec3 position;
in vec2 uv;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform sampler2D smoothed, mask; // smoothed: heights averaged over about a square of the mesh
uniform bool cut; // show only faces that lie wholly inside the mask: the others would be stretched into spikes
uniform float lift; // scene lengths for one unit of height; 0 lays the sheet flat
uniform vec2 cells; // squares of the mesh along x and y
out vec2 at;
out vec2 grid;
out vec3 scenePosition;
out float measured; // below 1 on a face with a corner outside the mask
${sampling}
void main() {
  at = uv;
  measured = cut ? step(0.96, textureLod(mask, uv, 0.0).r) : 1.0;
  grid = inKnown(uv) * cells;
  scenePosition = vec3(position.xy, lift == 0.0 ? 0.0 : heightAt(smoothed, inKnown(uv)) * lift);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(scenePosition, 1.0);
}`;

export const fragment = /* glsl */ `
precision highp float;
precision highp sampler2D;
uniform sampler2D heights, smoothed, albedo, normals, photo, lampA, lampB, lampC;
uniform vec4 part; // what of the sheet albedo, normals and photographs show: left, top, width, height
uniform bool photographed; // whether the photograph is another picture than the albedo
uniform int mode; // 0 sheet, 1 mesh, 2 heights, 3 contours, 4 the photograph, 5 normals
uniform int lens; // as mode, -1 none, 6 magnified
uniform vec3 lensPosition; // u, v, radius as a fraction of the longer side
uniform bool lensAlone; // draw nothing but what is in the lens, over a sheet that is drawn already
uniform vec2 sheet; // width and height where the longer side is 1
uniform vec3 light; // unit vector to the lamp
uniform int look; // 0 a warm lamp, 1 exact, 2 clay
uniform float sheen;
uniform vec3 eye;
uniform vec3 mixture; // weights of three photographs; all 0 where there are none
uniform float exaggeration; // of the slopes that are lit
uniform vec2 range; // lowest and highest height
uniform vec2 cells; // squares of the mesh along x and y
uniform float interval; // between two contour lines
uniform vec3 inkColour, paperColour;
in vec2 at;
in vec2 grid;
in vec3 scenePosition;
in float measured;
out vec4 colour;
${sampling}
${lampFunctions}
vec3 mixPhotographs(vec3 a, vec3 b, vec3 c, vec3 w) {
  return max(w.x * a + w.y * b + w.z * c, 0.0);
}
float contourDistance(float h, float step) {
  float v = h / step;
  return abs(v - floor(v + 0.5));
}
const vec3 clay = vec3(0.6, 0.53, 0.45);
const vec3 anchors[${ANCHORS.length}] = vec3[](${ANCHORS.map((c) => `vec3(${c.join(", ")})`).join(", ")});
vec3 heightColour(float t) {
  float x = clamp(t, 0.0, 1.0) * ${(ANCHORS.length - 1).toFixed(1)};
  int k = min(int(x), ${ANCHORS.length - 2});
  return mix(anchors[k], anchors[k + 1], x - float(k));
}
vec2 inPart(vec2 uv) {
  return (uv - part.xy) / part.zw;
}
vec3 normalAt(vec2 uv) {
  return exaggerate(decodeNormal(texture(normals, inPart(uv)).rgb), exaggeration);
}
vec3 sheetAt(vec2 uv) { // linear; the albedo texture is decoded by the sampler
  if (mixture != vec3(0.0)) {
    vec3 photographed = mixPhotographs(texture(lampA, inPart(uv)).rgb, texture(lampB, inPart(uv)).rgb, texture(lampC, inPart(uv)).rgb, mixture);
    return min(look == 1 ? photographed : photographed * exposure(light) * warm, 1.0);
  }
  vec3 a = look == 2 ? clay : texture(albedo, inPart(uv)).rgb;
  if (look == 1) return lambert(a, normalAt(uv), light);
  return warmLamp(a, normalAt(uv), light, normalize(eye - scenePosition), look == 2 ? 0.0 : sheen);
}
vec3 heightsAt(vec2 uv) {
  float t = (heightAt(heights, inKnown(uv)) - range.x) / max(range.y - range.x, 1e-9);
  return srgbToLinear(heightColour(t)) * mix(1.0, shading(normalAt(uv), light), 0.5);
}
vec3 contoursAt(vec2 uv) {
  float h = heightAt(smoothed, inKnown(uv));
  float wide = max(fwidth(h) / interval, 1e-6);
  float line = 1.0 - smoothstep(0.6, 1.6, contourDistance(h, interval) / wide);
  float fifth = 1.0 - smoothstep(0.6, 1.6, contourDistance(h, interval * 5.0) / (wide / 5.0) / 1.8);
  float t = (h - range.x) / max(range.y - range.x, 1e-9);
  vec3 base = mix(srgbToLinear(paperColour), srgbToLinear(heightColour(t)), 0.18);
  // Zero is the sheet itself: a line there would follow the grain of the paper, and run round all ink.
  float off = abs(h) / interval;
  float drawn = max(line * 0.75 * step(0.5, off), fifth * step(2.5, off));
  return mix(base, srgbToLinear(inkColour), drawn * (1.0 - smoothstep(0.25, 0.6, wide)));
}
vec3 meshAt() {
  vec3 n = normalize(cross(dFdx(scenePosition), dFdy(scenePosition)));
  n = n.z < 0.0 ? -n : n;
  vec2 f = fract(grid);
  vec2 w = fwidth(grid);
  vec2 side = min(f, 1.0 - f) / w;
  vec2 one = 1.0 / cells;
  vec2 corner = floor(grid) * one;
  float falls = abs(heightAt(smoothed, corner) - heightAt(smoothed, corner + one));
  float rises = abs(heightAt(smoothed, corner + vec2(one.x, 0.0)) - heightAt(smoothed, corner + vec2(0.0, one.y)));
  float diagonal = abs(falls < rises ? f.x - f.y : f.x + f.y - 1.0) / (w.x + w.y); // as grid() in scene.ts folds the square
  float line = 1.0 - smoothstep(0.2, 1.1, min(min(side.x, side.y), diagonal));
  vec3 base = srgbToLinear(vec3(0.93, 0.9, 0.83)) * (0.12 + 0.88 * shading(n, light));
  return mix(base, srgbToLinear(vec3(0.18, 0.29, 0.43)), line * 0.55 * (1.0 - smoothstep(0.3, 0.9, max(w.x, w.y))));
}
vec3 layerAt(int what, vec2 uv) {
  if (what == 1) return meshAt();
  if (what == 2) return heightsAt(uv);
  if (what == 3) return contoursAt(uv);
  if (what == 4) return photographed ? texture(photo, inPart(uv)).rgb : texture(albedo, inPart(uv)).rgb;
  if (what == 5) return srgbToLinear(normalAt(uv) * 0.5 + 0.5);
  return sheetAt(uv);
}
void main() {
  vec3 linear;
  float alpha = 1.0;
  vec2 away = (at - lensPosition.xy) * sheet;
  float d = length(away) / max(lensPosition.z, 1e-6);
  // Both are computed outside of a branch on the pixel, so that derivatives hold at the lens's rim.
  vec3 plain = layerAt(mode, at);
  if (lens >= 0) {
    vec3 through = lens == 6 ? layerAt(mode, lensPosition.xy + (at - lensPosition.xy) / 2.5) : layerAt(lens, at);
    float edge = fwidth(d);
    linear = mix(through, plain, smoothstep(1.0 - edge, 1.0 + edge, d));
    float rim = 1.0 - smoothstep(0.0, 2.0 * edge, abs(d - 1.0));
    if (lensAlone && d > 1.0) {
      linear = through;
      alpha = rim;
    }
    linear = mix(linear, srgbToLinear(vec3(0.64, 0.15, 0.11)), lensAlone && d > 1.0 ? 1.0 : rim);
  } else {
    linear = plain;
  }
  if (measured < 0.98) discard;
  colour = vec4(linearToSrgb(linear), alpha);
}`;
