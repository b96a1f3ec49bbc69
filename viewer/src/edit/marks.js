/** Lines over the scene: the edges of a box, a circle, a lasso; and clicks and strokes for tools. */

import { dot, plus } from "../viewer/vector.js";

/** @typedef {import("../render/types.js").Camera} Camera */
/** @typedef {import("../viewer/viewer.js").Viewer} Viewer */
/** @typedef {import("../viewer/vector.js").Vector} Vector */
/** @typedef {import("./selection.js").Box} Box */

const CIRCLE = 48; // corners of a circle
const SVG = "http://www.w3.org/2000/svg";
const EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]]; // prettier-ignore

export class Marks {
  element = document.createElement("div");
  #viewer;
  #path = document.createElementNS(SVG, "path");
  /** @type {(() => string) | null} */
  #shape = null;

  /** @param {() => Viewer} viewer */
  constructor(viewer) {
    this.#viewer = viewer;
    this.element.id = "marks";
    const svg = document.createElementNS(SVG, "svg");
    svg.append(this.#path);
    this.element.append(svg);
  }

  /** Draw again, after the camera moved. */
  draw() {
    this.#path.setAttribute("d", this.#shape?.() ?? "");
  }

  clear() {
    this.#shape = null;
    this.draw();
  }

  /** @param {Box} box */
  box({ center, half, axes }) {
    const corners = Array.from({ length: 8 }, (_, i) =>
      axes.reduce((at, axis, k) => plus(at, axis, i & (1 << k) ? half[k] : -half[k]), center),
    );
    this.#lines(EDGES.map((edge) => edge.map((i) => corners[i])));
  }

  /** Three circles of a sphere. @param {Vector} center @param {number} radius */
  sphere(center, radius) {
    this.#lines([0, 1, 2].map((axis) => ring(center, radius, (axis + 1) % 3, (axis + 2) % 3)));
  }

  /** A square of a plane. @param {Vector} center @param {Vector} right @param {Vector} ahead half edges */
  square(center, right, ahead) {
    const corner = (/** @type {number} */ a, /** @type {number} */ b) => plus(plus(center, right, a), ahead, b);
    this.#lines([[corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1), corner(-1, -1)]]);
  }

  /**
   * Wait for a click on the scene.
   *
   * @param {(x: number, y: number) => void} act pixels
   * @returns {() => void} gives up
   */
  click(act) {
    return this.#listen({ pointerup: (event) => act(event.offsetX, event.offsetY) });
  }

  /**
   * Wait for a closed stroke.
   *
   * @param {(polygon: [number, number][]) => void} act
   * @returns {() => void} gives up
   */
  lasso(act) {
    /** @type {[number, number][]} */
    let polygon = [];
    this.#path.classList.add("shade");
    const end = this.#listen({
      pointerdown: (event) => {
        this.element.setPointerCapture(event.pointerId);
        polygon = [[event.offsetX, event.offsetY]];
      },
      pointermove: (event) => {
        if (!event.buttons || !polygon.length) return;
        polygon.push([event.offsetX, event.offsetY]);
        this.#path.setAttribute("d", `M${polygon.join("L")}Z`);
      },
      pointerup: () => {
        if (polygon.length > 2) act(polygon);
        polygon = [];
        this.#path.setAttribute("d", "");
      },
    });
    return () => {
      this.#path.classList.remove("shade");
      end();
    };
  }

  /** @param {Record<string, (event: PointerEvent) => void>} events @returns {() => void} */
  #listen(events) {
    const over = new AbortController();
    this.element.classList.add("drawing");
    for (const [kind, act] of Object.entries(events)) {
      this.element.addEventListener(kind, /** @type {EventListener} */ (act), { signal: over.signal });
    }
    return () => {
      over.abort();
      this.element.classList.remove("drawing");
    };
  }

  /** Draw lines through points of the world. @param {Vector[][]} lines */
  #lines(lines) {
    this.#shape = () => {
      const { clientWidth, clientHeight } = this.element;
      const camera = this.#viewer().camera(clientWidth, clientHeight);
      return lines.map((points) => projected(points, camera)).join("");
    };
    this.draw();
  }
}

/** @param {Vector} center @param {number} radius @param {number} a @param {number} b axes of its plane */
function ring(center, radius, a, b) {
  return Array.from({ length: CIRCLE + 1 }, (_, i) => {
    const point = /** @type {Vector} */ ([...center]);
    point[a] += radius * Math.cos((2 * Math.PI * i) / CIRCLE);
    point[b] += radius * Math.sin((2 * Math.PI * i) / CIRCLE);
    return point;
  });
}

/** The path of a line through points; parts behind the camera are left out. @param {Vector[]} points @param {Camera} camera */
function projected(points, { viewmat: m, fx, fy, cx, cy, near }) {
  let pen = "M";
  let text = "";
  for (const point of points) {
    const [x, y, z] = [0, 4, 8].map((i) => dot([m[i], m[i + 1], m[i + 2]], point) + m[i + 3]);
    if (z > near) text += `${pen}${((fx * x) / z + cx).toFixed(1)} ${((fy * y) / z + cy).toFixed(1)}`;
    pen = z > near ? "L" : "M";
  }
  return text;
}
