// SPDX-License-Identifier: GPL-3.0-or-later
// Draws a surface with its points, or points in space, by WebGL 2.

const surfaceVertex = `#version 300 es
uniform mat3 turn;
uniform vec4 place;
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 normal;
out vec3 facing;
out vec3 edges;
void main() {
  facing = turn * normal;
  edges = vec3(equal(ivec3(gl_VertexID % 3), ivec3(0, 1, 2)));
  vec3 at = turn * corner;
  gl_Position = vec4(place.xy + place.zw * at.xy, -at.z, 1);
}`;

const surfaceFragment = `#version 300 es
precision highp float;
uniform vec3 light;
uniform vec3 colour;
uniform vec3 line;
uniform float lineWidth;
in vec3 facing;
in vec3 edges;
out vec4 result;
void main() {
  vec3 normal = normalize(gl_FrontFacing ? facing : -facing);
  float shade = 0.5 + 0.5 * max(dot(normal, light), 0.0);
  vec3 shaded = shade * colour * (gl_FrontFacing ? vec3(1) : vec3(1, 0.86, 0.72));
  vec3 distances = edges / max(fwidth(edges), vec3(1e-6));
  float nearest = min(distances.x, min(distances.y, distances.z));
  float share = lineWidth > 0.0 ? 1.0 - smoothstep(0.5 * lineWidth - 0.5, 0.5 * lineWidth + 0.5, nearest) : 0.0;
  result = vec4(mix(shaded, line, share), 1);
}`;

// A disc is a square around the point, perpendicular to its normal, whose corners are transparent. It is moved towards
// the viewer, so that a curved surface does not cover it. A disc that is seen from the side is moved less, because it
// would stick out beside the surface. Where the surface below is farther from the plane of the disc than `margin`, beyond
// an edge of the surface, the disc is cut off. Without a normal, a disc faces the viewer, is whole, and fades with distance.
const pointVertex = `#version 300 es
uniform mat3 turn;
uniform vec4 place;
uniform float radius;
layout(location = 0) in vec3 point;
layout(location = 1) in vec3 normal;
out vec2 offset;
out float fading;
out float above;
flat out float slant;
void main() {
  bool isFree = normal == vec3(0);
  vec3 facing = isFree ? vec3(0, 0, 1) * turn : normal;
  offset = 1.2 * vec2(gl_VertexID % 2 * 2 - 1, gl_VertexID / 2 * 2 - 1);
  vec3 across = normalize(cross(facing, abs(facing.x) < 0.7 ? vec3(1, 0, 0) : vec3(0, 1, 0)));
  vec3 at = turn * (point + radius * (offset.x * across + offset.y * cross(facing, across)));
  above = at.z;
  slant = isFree ? 0.0 : abs((turn * facing).z);
  fading = isFree ? 0.8 * clamp(0.5 - at.z, 0.0, 1.0) : 0.0;
  float nearer = radius * (0.1 + 0.5 * (isFree ? 1.0 : slant));
  gl_Position = vec4(place.xy + place.zw * at.xy, -at.z - nearer, 1);
}`;

const pointFragment = `#version 300 es
precision highp float;
uniform vec3 ink;
uniform vec3 paper;
uniform highp sampler2D depths;
uniform float margin;
in vec2 offset;
in float fading;
in float above;
flat in float slant;
out vec4 result;
void main() {
  float distance = length(offset);
  float gap = slant * (above + 2.0 * texelFetch(depths, ivec2(gl_FragCoord), 0).r - 1.0);
  float cover = clamp(0.5 + (1.0 - distance) / max(fwidth(distance), 1e-6), 0.0, 1.0) * clamp(2.0 - gap / margin, 0.0, 1.0);
  if (cover == 0.0) discard;
  result = cover * vec4(mix(ink, paper, fading), 1);
}`;

const leastMargin = 0.001;  // distance of points from the shown surface, which has fewer vertices than the given one

/**
 * Compiles a program. Returns it with a function that finds its uniforms. Errors are not checked: if the context is lost,
 * `restore` compiles the program again.
 */
function programOf(gl, ...sources) {
  const program = gl.createProgram();
  [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind, i) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, sources[i]);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  });
  gl.linkProgram(program);
  return { program, at: (name) => gl.getUniformLocation(program, name) };
}

/** Uploads arrays of vectors as attributes 0 and 1. With `divisor` 1, each instance has one vector. */
function arrayOf(gl, arrays, divisor) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  const buffers = arrays.map((values, location) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, 3, gl.FLOAT, false, 0, 0);
    gl.vertexAttribDivisor(location, divisor);
    return buffer;
  });
  return { array, remove: () => { buffers.forEach((buffer) => gl.deleteBuffer(buffer)); gl.deleteVertexArray(array); } };
}

export class WebglPainter {
  #gl;
  #scene = null;
  #surfaceArray = null;
  #pointArray = null;
  #depths = null;  // {texture, buffer, size}: the depth of the surface at each pixel

  constructor(gl) {
    this.#gl = gl;
    this.#begin();
  }

  #begin() {
    const gl = this.#gl;
    this.surface = programOf(gl, surfaceVertex, surfaceFragment);
    this.points = programOf(gl, pointVertex, pointFragment);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** Compiles and uploads everything again after the browser has lost and restored the context. */
  restore() {
    this.#scene = this.#surfaceArray = this.#pointArray = this.#depths = null;
    this.#begin();
  }

  #load(scene) {
    if (this.#scene === scene) return;
    this.#scene = scene;
    this.#surfaceArray?.remove();
    this.#pointArray?.remove();
    this.#surfaceArray = arrayOf(this.#gl, [scene.corners, scene.normals], 0);
    this.#pointArray = arrayOf(this.#gl, [scene.points, scene.pointNormals], 1);
  }

  /** Selects a buffer for the depths of the surface, as large as the canvas. */
  #beginDepths() {
    const gl = this.#gl;
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    this.#depths ??= { texture: gl.createTexture(), buffer: gl.createFramebuffer() };
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#depths.buffer);
    gl.bindTexture(gl.TEXTURE_2D, this.#depths.texture);
    if (this.#depths.size === `${width} ${height}`) return;
    this.#depths.size = `${width} ${height}`;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.DEPTH_COMPONENT24, width, height, 0, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.#depths.texture, 0);
  }

  /**
   * Draws a scene.
   * @param scene  result of `sceneOf` or `volumeSceneOf`
   * @param view   {turn, x, y, scale, width, height, ratio, radius, first, light, lineWidth, colours}: rotation as nine
   *               numbers in columns; place of the origin and length of a unit, in CSS pixels; size of the canvas in CSS
   *               pixels; device pixels per CSS pixel; radius of a disc; number of points to draw; direction to the
   *               light; width of the edges, 0 for none; and colours as numbers from 0 to 1
   */
  draw(scene, { turn, x, y, scale, width, height, ratio, radius, first, light, lineWidth, colours }) {
    const gl = this.#gl;
    this.#load(scene);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(0, 0, 0, 0);
    const begin = ({ program, at }) => {
      gl.useProgram(program);
      gl.uniformMatrix3fv(at("turn"), false, turn);
      gl.uniform4f(at("place"), (2 * x) / width - 1, 1 - (2 * y) / height, (2 * scale) / width, (2 * scale) / height);
      return at;
    };
    const ofSurface = begin(this.surface);
    gl.uniform3fv(ofSurface("light"), light);
    gl.uniform3fv(ofSurface("colour"), colours.surface);
    gl.uniform3fv(ofSurface("line"), colours.line);
    gl.uniform1f(ofSurface("lineWidth"), lineWidth * ratio);
    gl.bindVertexArray(this.#surfaceArray.array);
    this.#beginDepths();
    for (const buffer of [this.#depths.buffer, null]) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.drawArrays(gl.TRIANGLES, 0, scene.corners.length / 3);
    }

    const ofPoints = begin(this.points);
    gl.uniform1f(ofPoints("radius"), radius);
    gl.uniform1f(ofPoints("margin"), 0.1 * radius + leastMargin);
    gl.uniform3fv(ofPoints("ink"), colours.ink);
    gl.uniform3fv(ofPoints("paper"), colours.paper);
    gl.enable(gl.BLEND);
    gl.depthMask(Boolean(scene.isFree));  // on a surface, smooth borders of discs must not hide other discs
    gl.bindVertexArray(this.#pointArray.array);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, first);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }
}
