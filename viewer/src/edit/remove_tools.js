/** Tools that remove Gaussians, each a section of the panel: box, sphere, lasso, floor, cameras. */

import { cross, dot, minus, plus, turned, unit } from "../viewer/vector.js";
import { button, hint, make, row, section, slider } from "./panel.js";
import { below, inBox, inLasso, inSphere, inverted, seenByFewer } from "./selection.js";

/** @typedef {import("../edit.js").Editor} Editor */
/** @typedef {import("../viewer/vector.js").Vector} Vector */
/** @typedef {import("./selection.js").Box} Box */
/** @typedef {import("./selection.js").Mask} Mask */

const SAMPLE = 20_000; // Gaussians from which sizes are measured
const FEW = 20; // cameras, of which fewer tell little
const SIDES = ["Left", "Right", "Bottom", "Top", "Front", "Back"];

/** Axes of the room: right, up, ahead. @param {Vector} up @returns {[Vector, Vector, Vector]} */
export function roomAxes(up) {
  const away = Math.abs(up[2]) < 0.9 ? /** @type {Vector} */ ([0, 0, 1]) : /** @type {Vector} */ ([0, 1, 0]);
  const right = unit(cross(away, up));
  return [right, up, unit(cross(up, right))];
}

/** Centre of the scene, and where it begins and ends along each axis. @param {Float32Array} means @param {Vector[]} axes */
export function extent(means, axes) {
  const count = means.length / 3;
  const every = Math.max(1, Math.floor(count / SAMPLE));
  /** @type {Vector[]} */
  const points = [];
  for (let i = 0; i < count; i += every) points.push([means[3 * i], means[3 * i + 1], means[3 * i + 2]]);
  const ends = axes.map((axis) => {
    const along = Float64Array.from(points, (point) => dot(point, axis)).sort();
    const at = (/** @type {number} */ share) => along[Math.floor(share * (along.length - 1))];
    return { low: at(0.002), middle: at(0.5), high: at(0.998), size: at(0.9) - at(0.1) };
  });
  const center = axes.reduce((sum, axis, k) => plus(sum, axis, ends[k].middle), /** @type {Vector} */ ([0, 0, 0]));
  return { center, ends, size: Math.max(...ends.map(({ size }) => size)) || 1 };
}

/** A choice between removing what is inside and what is outside. @param {() => void} changed */
function insideChoice(changed) {
  const select = make("select", { onchange: changed }, new Option("Keep what is inside", "keep"), new Option("Remove what is inside", "remove"));
  return {
    label: make("label", {}, "Effect", select),
    mask: (/** @type {Mask} */ inside) => (select.value === "keep" ? inverted(inside) : inside),
  };
}

/** @param {Editor} editor */
export function boxTool(editor) {
  const { viewer, marks } = editor;
  const axes = roomAxes(viewer.pose.up);
  const { center, ends } = extent(viewer.means, axes);
  const update = () => {
    marks.box(box());
    editor.preview(() => choice.mask(inBox(viewer.means, box())));
  };
  const sliders = SIDES.map((name, i) => {
    const { low, middle, high } = ends[i >> 1];
    return slider(name, { min: low - middle, max: high - middle, value: (i % 2 ? high : low) - middle }, update);
  });
  const turn = slider("Turn", { min: -45, max: 45, value: 0, step: 1 }, update);
  const choice = insideChoice(update);
  /** @returns {Box} */
  const box = () => {
    const angle = (Number(turn.input.value) * Math.PI) / 180;
    const turnedAxes = /** @type {[Vector, Vector, Vector]} */ (axes.map((axis) => turned(axis, axes[1], angle)));
    const values = sliders.map(({ input }) => Number(input.value));
    const middles = [0, 2, 4].map((i) => (values[i] + values[i + 1]) / 2);
    return {
      center: turnedAxes.reduce((at, axis, k) => plus(at, axis, middles[k]), center),
      half: /** @type {Vector} */ ([0, 2, 4].map((i) => Math.abs(values[i + 1] - values[i]) / 2)),
      axes: turnedAxes,
    };
  };
  const apply = button("Apply", () => {
    editor.remove(choice.mask(inBox(viewer.means, box())));
    update();
  });
  const parts = [choice.label, ...sliders.map(({ label }) => label), turn.label, row(apply)];
  return section("Crop box", parts, { opened: update, closed: () => editor.put() });
}

/** @param {Editor} editor */
export function sphereTool(editor) {
  const { viewer, marks } = editor;
  const { size } = extent(viewer.means, roomAxes(viewer.pose.up));
  let center = viewer.pose.target;
  const update = () => {
    const radius = Math.exp(Number(input.value));
    marks.sphere(center, radius);
    editor.preview(() => choice.mask(inSphere(viewer.means, center, radius)));
  };
  const { input, label } = slider(
    "Radius", { min: Math.log(0.005 * size), max: Math.log(3 * size), value: Math.log(0.15 * size) }, update,
  ); // prettier-ignore
  const choice = insideChoice(update);
  /** @type {HTMLSelectElement} */ (choice.label.lastElementChild).value = "remove";
  const pick = button("Click its centre", () =>
    editor.pick((point) => {
      center = point;
      update();
    }),
  );
  const apply = button("Apply", () => {
    editor.remove(choice.mask(inSphere(viewer.means, center, Math.exp(Number(input.value)))));
    update();
  });
  const opened = () => {
    center = viewer.pose.target;
    update();
  };
  return section("Sphere", [row(pick), label, choice.label, row(apply)], { opened, closed: () => editor.put() });
}

/** @param {Editor} editor */
export function lassoTool(editor) {
  const { viewer, marks } = editor;
  const draw = button("Draw a lasso", () => {
    editor.put();
    draw.setAttribute("aria-pressed", "true");
    editor.tool = marks.lasso((polygon) => {
      const { clientWidth, clientHeight } = marks.element;
      const removed = editor.remove(inLasso(viewer.means, viewer.camera(clientWidth, clientHeight), polygon));
      editor.say(`${removed.toLocaleString("en")} Gaussians removed by the lasso.`);
    });
  });
  const stop = button("Move the camera again", () => {
    draw.setAttribute("aria-pressed", "false");
    editor.put();
  });
  const note = hint("Removes everything inside the line, in front and behind: turn the scene so that nothing else is there.");
  return section("Lasso", [note, row(draw, stop)], { closed: () => stop.click() });
}

/** @param {Editor} editor */
export function floorTool(editor) {
  const { viewer, marks, settings } = editor;
  let normal = viewer.pose.up;
  let [low, high, size] = [0, 1, 1];
  const { input, label } = slider("Height", { min: 0, max: 1, value: 0.05 }, () => update());
  const offset = () => low + Number(input.value) * (high - low);
  const measure = () => {
    const axes = roomAxes(normal);
    const found = extent(viewer.means, axes);
    [low, high, size] = [found.ends[1].low, found.ends[1].high, found.size];
    return { axes, found };
  };
  const update = () => {
    const { axes, found } = measure();
    const middle = plus(found.center, normal, offset() - dot(found.center, normal));
    const edge = (/** @type {Vector} */ axis) => plus([0, 0, 0], axis, size);
    marks.square(middle, edge(axes[0]), edge(axes[2]));
    editor.preview(cuts.checked ? () => below(viewer.means, normal, offset()) : null);
  };
  const cuts = make("input", { type: "checkbox", onchange: () => update() });
  cuts.style.width = "auto";
  const three = button("Click three points of the floor", () => {
    /** @type {Vector[]} */
    const points = [];
    const next = (/** @type {Vector} */ point) => {
      points.push(point);
      if (points.length < 3) {
        editor.pick(next);
        return;
      }
      const found = unit(cross(minus(points[1], points[0]), minus(points[2], points[0])));
      normal = dot(found, viewer.pose.up) < 0 ? minus([0, 0, 0], found) : found;
      measure();
      input.value = String((dot(points[0], normal) - low) / (high - low));
      update();
    };
    editor.pick(next);
  });
  const use = button("Use as the floor", () => {
    settings.floor = [...normal, offset()];
    editor.changed("The floor is set.");
  });
  const upright = button("Let it be level", () => editor.setUp(normal));
  const remove = button("Remove what is below", () => {
    editor.remove(below(viewer.means, normal, offset()));
    update();
  });
  const opened = () => {
    normal = viewer.pose.up;
    update();
  };
  const parts = [
    row(three), label, make("label", {}, "Preview", cuts), row(use, upright, remove),
    hint("Level: the floor's direction becomes the upward direction of the scene."),
  ]; // prettier-ignore
  return section("Floor", parts, { opened, closed: () => editor.put() });
}

/** @param {Editor} editor */
export function camerasTool(editor) {
  /** @type {Uint16Array | null} */
  let seen = null;
  const note = hint("");
  const mask = () => seenByFewer(seen ?? new Uint16Array(0), Number(input.value));
  const update = () => {
    if (!seen) return;
    const least = Number(input.value);
    const count = mask().reduce((sum, value) => sum + value, 0);
    told.textContent = `${count.toLocaleString("en")} Gaussians were seen by fewer than ${least} camera${least === 1 ? "" : "s"}.`;
    editor.preview(mask);
  };
  const { input, label } = slider("Cameras", { min: 0, max: 1, value: 0, step: 1 }, update);
  const told = hint("");
  const apply = button("Remove these", () => {
    if (seen) editor.remove(mask());
    update();
  });
  const opened = async () => {
    if (seen) return update();
    note.textContent = "The cameras are being counted: this takes some seconds.";
    const answer = await fetch("cameras");
    if (!answer.ok) {
      note.textContent = (await answer.json()).error;
      return;
    }
    const [cameras, ...counts] = new Uint16Array(await answer.arrayBuffer());
    seen = Uint16Array.from(counts);
    const warning = cameras < FEW ? " Most photos are not among them: start with --capture to count all." : "";
    note.textContent = `Counted: ${answer.headers.get("X-Cameras")} (${cameras}).${warning}`;
    input.max = String(Math.max(1, Math.ceil(cameras / 4)));
    update();
  };
  return section("Seen by few cameras", [note, label, told, row(apply)], { opened, closed: () => editor.put() });
}
