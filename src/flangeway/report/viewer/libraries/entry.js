// What the viewer takes from its libraries, as one global object; see README.md for how it is bundled.
export {
  BufferAttribute,
  BufferGeometry,
  DataTexture,
  FloatType,
  GLSL3,
  Group,
  LinearFilter,
  LineSegments,
  Mesh,
  MOUSE,
  NearestFilter,
  OrthographicCamera,
  RawShaderMaterial,
  RedFormat,
  RGBAFormat,
  Scene,
  ShapeUtils,
  TOUCH,
  UnsignedByteType,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
export { MapControls } from "three/addons/controls/MapControls.js";
export { default as Flatbush } from "flatbush";
