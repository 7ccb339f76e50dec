// Where the picture looks: drag, wheel, pinch, keys, and flights to places. Its zoom is pixels a millimetre.

const FLIGHT_MS = 350;
const HINT_MS = 1500;
const LARGEST_ZOOM = 2e4;
const TILTED = [0, -0.75, 0.65]; // towards the camera
const ABOVE = [0, -1e-4, 1];

class Navigation {
  constructor(picture, canvas, changed) {
    const { MapControls, MOUSE, TOUCH } = viewerLibraries;
    this.camera = picture.camera;
    this.canvas = canvas;
    this.solid = picture.solid;
    this.seen = new viewerLibraries.Vector3();
    this.controls = new MapControls(this.camera, canvas);
    Object.assign(this.controls, { enableRotate: this.solid, screenSpacePanning: true, zoomToCursor: true, zoomSpeed: 1.5 });
    if (this.solid) this.controls.maxPolarAngle = 1.5;
    this.controls.mouseButtons = { LEFT: MOUSE.PAN, MIDDLE: MOUSE.DOLLY, RIGHT: this.solid ? MOUSE.ROTATE : MOUSE.PAN };
    this.controls.touches = { ONE: TOUCH.PAN, TWO: this.solid ? TOUCH.DOLLY_ROTATE : TOUCH.DOLLY_PAN };
    this.controls.addEventListener("change", changed);
    // the wheel scrolls the page, which the picture does not hold; with Ctrl or Command it zooms
    const hint = canvas.parentElement.querySelector(".viewer-hint");
    const scrolled = (event) => {
      if (event.ctrlKey || event.metaKey) return;
      event.stopPropagation();
      hint.hidden = false;
      clearTimeout(this.hinted);
      this.hinted = setTimeout(() => (hint.hidden = true), HINT_MS);
    };
    canvas.parentElement.addEventListener("wheel", scrolled, { capture: true, passive: true });
    this.controls.addEventListener("start", () => cancelAnimationFrame(this.flight));
  }

  // Limits between which wheel, pinch and keys may zoom; `whole` shows all.
  limit(whole) {
    this.controls.minZoom = whole / 3;
    this.controls.maxZoom = LARGEST_ZOOM;
  }

  zoomOf([x0, y0, x1, y1]) {
    const { clientWidth, clientHeight } = this.canvas;
    return Math.min(clientWidth / Math.max(x1 - x0, 1e-6), clientHeight / Math.max(y1 - y0, 1e-6));
  }

  // Turn the picture: towards the camera from where it looks.
  turn(towards) {
    const { target } = this.controls;
    this.camera.position.set(...towards).setLength(DISTANCE).add(target);
    this.look(target.x, target.y, this.camera.zoom);
  }

  look(x, y, zoom) {
    const { target } = this.controls;
    this.camera.position.sub(target).add(target.set(x, y, 0));
    this.camera.zoom = Math.min(Math.max(zoom, this.controls.minZoom), this.controls.maxZoom);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.controls.dispatchEvent({ type: "change" });
  }

  // Show a box in mm: least x, least y, greatest x, greatest y. Out, across and in again, as maps do.
  fly(box, arrived = () => {}) {
    cancelAnimationFrame(this.flight);
    const { target } = this.controls;
    const from = { x: target.x, y: target.y, zoom: this.camera.zoom };
    const to = { x: (box[0] + box[2]) / 2, y: (box[1] + box[3]) / 2, zoom: this.zoomOf(box) };
    const end = () => {
      this.look(to.x, to.y, to.zoom);
      arrived();
    };
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return end();
    const began = performance.now();
    const step = (now) => {
      const t = Math.min(1, Math.max(0, now - began) / FLIGHT_MS);
      if (t >= 1) return end();
      const eased = t * t * (3 - 2 * t);
      const zoom = from.zoom * (to.zoom / from.zoom) ** eased;
      // what is seen moves evenly: the share of the way follows the width of the view
      const share = Math.abs(to.zoom / from.zoom - 1) < 1e-6 ? eased : (1 / from.zoom - 1 / zoom) / (1 / from.zoom - 1 / to.zoom);
      this.look(from.x + share * (to.x - from.x), from.y + share * (to.y - from.y), zoom);
      this.flight = requestAnimationFrame(step);
    };
    this.flight = requestAnimationFrame(step);
  }

  // Move by shares of what is seen.
  pan(right, up) {
    cancelAnimationFrame(this.flight);
    const { clientWidth, clientHeight } = this.canvas;
    const { target } = this.controls;
    const { zoom } = this.camera;
    this.look(target.x + (right * clientWidth) / zoom, target.y + (up * clientHeight) / zoom, zoom);
  }

  zoomBy(factor) {
    cancelAnimationFrame(this.flight);
    this.look(this.controls.target.x, this.controls.target.y, this.camera.zoom * factor);
  }

  // The place in mm at a pixel of the canvas.
  placeAt(pixelX, pixelY) {
    const { clientWidth, clientHeight } = this.canvas;
    const { position, zoom } = this.camera;
    return [position.x + (pixelX - clientWidth / 2) / zoom, position.y - (pixelY - clientHeight / 2) / zoom];
  }

  // The pixel of the canvas at a place in mm, and its depth.
  pixelOf([x, y, height = 0]) {
    const { clientWidth, clientHeight } = this.canvas;
    const { position, zoom } = this.camera;
    if (!this.solid) return [(x - position.x) * zoom + clientWidth / 2, (position.y - y) * zoom + clientHeight / 2];
    const seen = this.seen.set(x, y, height).project(this.camera);
    return [((1 + seen.x) * clientWidth) / 2, ((1 - seen.y) * clientHeight) / 2, seen.z];
  }
}
