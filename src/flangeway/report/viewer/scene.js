// The picture: parts as triangles whose places and values the graphics card looks up by point and cell.

const TEXTURE_WIDTH = 2048;
const DISTANCE = 1000; // of the camera from the plane of the picture
const SHADE = 0.35; // of heights: how much darker what turns away from the light is

const COMMON_SHADER = `
precision highp float;
precision highp int;
precision highp sampler2D;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform sampler2D motion;
uniform float factor;
in uint node;
in float height;
out vec3 at;
ivec2 place(uint number) { return ivec2(int(number) % ${TEXTURE_WIDTH}, int(number) / ${TEXTURE_WIDTH}); }
vec4 drawnAt(uint number) {
  vec4 moved = texelFetch(motion, place(number), 0);
  at = vec3(moved.xy + factor * moved.zw, height);
  return projectionMatrix * modelViewMatrix * vec4(at, 1.0);
}`;

const CELLS_VERTEX = `${COMMON_SHADER}
uniform sampler2D values;
uniform bool perCell;
in uint cell;
out float value;
void main() {
  gl_Position = drawnAt(node);
  value = texelFetch(values, place(perCell ? cell : node), 0).r;
}`;

const CELLS_FRAGMENT = `
precision highp float;
uniform sampler2D table;
uniform vec2 range;
uniform float shade;
in float value;
in vec3 at;
out vec4 colour;
void main() {
  float share = clamp((value - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0);
  colour = texture(table, vec2((share * 255.0 + 0.5) / 256.0, 0.5));
  vec3 normal = cross(dFdx(at), dFdy(at));
  float facing = abs(dot(normal, vec3(-0.35, -0.35, 0.87))) / max(length(normal), 1e-30);
  colour.rgb *= 1.0 - shade * (1.0 - facing);
}`;

const LINES_VERTEX = `${COMMON_SHADER}
void main() { gl_Position = drawnAt(node); }`;

const LINES_FRAGMENT = `
precision highp float;
uniform vec4 ink;
out vec4 colour;
void main() { colour = vec4(ink.rgb * ink.a, ink.a); }`;

class Picture {
  constructor(canvas, parts) {
    const { Scene, OrthographicCamera, WebGLRenderer } = viewerLibraries;
    // kept after drawing: the browser prints what is there
    this.renderer = new WebGLRenderer({ canvas, alpha: true, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setClearColor(0, 0);
    this.renderer.sortObjects = true;
    this.solid = parts.some((part) => part.heights);
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0.1, 2 * DISTANCE);
    this.camera.position.z = DISTANCE;
    if (this.solid) this.camera.up.set(0, 0, 1);
    this.scene = new Scene();
    this.shared = { factor: { value: 1 }, shade: { value: 0 }, range: { value: [0, 1] }, table: { value: null } };
    this.inks = { mesh: { value: [0.1, 0.11, 0.13, 0.35] }, outline: { value: [0.1, 0.11, 0.13, 0.9] } };
    this.items = parts.map((part) => this.added(part));
    this.pending = false;
  }

  added(part) {
    const { Group } = viewerLibraries;
    const group = new Group();
    const motion = { value: floatTexture(part.motion, 4) };
    const uniforms = { ...this.shared, motion, perCell: { value: true }, values: { value: null } };
    const cells = this.drawable("Mesh", part, part.corners, part.triangles, uniforms, CELLS_VERTEX, CELLS_FRAGMENT, 0);
    cells.geometry.setAttribute("cell", new viewerLibraries.BufferAttribute(part.cellOfCorner, 1));
    const points = Uint32Array.from({ length: part.points.length / 2 }, (_, i) => i);
    const lines = (index, ink, order) =>
      this.drawable("LineSegments", part, points, index, { ...this.shared, motion, ink }, LINES_VERTEX, LINES_FRAGMENT, order);
    const mesh = lines(part.edges, this.inks.mesh, 1);
    const outline = lines(part.boundary, this.inks.outline, 2);
    mesh.visible = false;
    group.add(cells, mesh, outline);
    this.scene.add(group);
    return { part, group, uniforms, motion, mesh };
  }

  drawable(kind, part, nodes, index, uniforms, vertexShader, fragmentShader, order) {
    const { BufferAttribute, BufferGeometry, GLSL3, RawShaderMaterial } = viewerLibraries;
    const geometry = new BufferGeometry();
    geometry.setAttribute("node", new BufferAttribute(nodes, 1));
    geometry.setAttribute("height", new BufferAttribute(Float32Array.from(nodes, (node) => heightOf(part, node)), 1));
    geometry.setIndex(new BufferAttribute(index, 1));
    const material = new RawShaderMaterial({ uniforms, vertexShader, fragmentShader, glslVersion: GLSL3 });
    const offset = { polygonOffset: this.solid, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
    const depth = { depthTest: this.solid, depthWrite: this.solid, ...offset };
    Object.assign(material, { ...depth, transparent: true, premultipliedAlpha: true, side: 2 });
    const drawable = new viewerLibraries[kind](geometry, material);
    drawable.frustumCulled = false;
    drawable.renderOrder = order;
    return drawable;
  }

  // Put the parts where they are drawn: at their origins, shifted sideways.
  place() {
    for (const { part, group } of this.items) group.position.set(part.origin[0] + part.shift, part.origin[1], 0);
  }

  // Move the points to where they are at the step of their parts.
  setMotion() {
    for (const { part, motion } of this.items) {
      motion.value.dispose();
      motion.value = floatTexture(part.motion, 4);
    }
  }

  // For each part its values, and whether they are of its cells or of its points.
  setValues(shown) {
    this.items.forEach(({ uniforms }, i) => {
      uniforms.perCell.value = shown[i].perCell;
      uniforms.values.value?.dispose();
      uniforms.values.value = floatTexture(shown[i].values, 1);
    });
  }

  setTable(bytes) {
    const { DataTexture, LinearFilter, RGBAFormat, UnsignedByteType } = viewerLibraries;
    const table = new DataTexture(bytes, N_COLOURS, 1, RGBAFormat, UnsignedByteType);
    table.minFilter = table.magFilter = LinearFilter;
    table.needsUpdate = true;
    this.shared.table.value?.dispose();
    this.shared.table.value = table;
  }

  resize(width, height) {
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    Object.assign(this.camera, { left: -width / 2, right: width / 2, top: height / 2, bottom: -height / 2 });
    this.camera.updateProjectionMatrix();
  }

  render() {
    this.renderer.render(this.scene, this.camera);
  }

  renderSoon() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.render();
    });
  }
}

function floatTexture(numbers, components) {
  const { DataTexture, FloatType, NearestFilter, RedFormat, RGBAFormat } = viewerLibraries;
  const height = Math.max(1, Math.ceil(numbers.length / components / TEXTURE_WIDTH));
  const padded = new Float32Array(TEXTURE_WIDTH * height * components);
  padded.set(numbers);
  const texture = new DataTexture(padded, TEXTURE_WIDTH, height, components === 1 ? RedFormat : RGBAFormat, FloatType);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}
