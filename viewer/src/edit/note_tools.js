/** Tools that set notes, each a section of the panel: texts, first view, upward direction, annotations, path. */

import { Dots, parsedAnnotations } from "../viewer/annotations.js";
import { flyTo, parsedPath, play } from "../viewer/camera_path.js";
import { AXES } from "../viewer/up.js";
import { button, field, hint, make, row, section } from "./panel.js";

/** @typedef {import("../edit.js").Editor} Editor */
/** @typedef {import("../viewer/annotations.js").Annotation} Annotation */

const TEXT_MAX = 1000; // characters of an annotation
const LINE_MAX = 200; // of a title or credit

/** @param {Editor} editor */
export function textTool(editor) {
  const { settings, notes } = editor;
  const parts = /** @type {const} */ (["title", "credit"]).map((name) => {
    const { input, label } = field(name === "title" ? "Title" : "Credit", String(notes[name] ?? ""), LINE_MAX);
    input.addEventListener("input", () => {
      settings[name] = input.value;
      editor.changed();
    });
    return label;
  });
  return section("Title and credit", parts);
}

/** @param {Editor} editor */
export function startTool(editor) {
  const { viewer, settings } = editor;
  const view = (/** @type {boolean} */ portrait) => {
    const { clientWidth: width, clientHeight: height } = editor.element;
    const { fx, fy } = viewer.camera(width, height);
    const [across, down] = [width / (2 * fx), height / (2 * fy)];
    // a window of the other shape shows what must be in the picture in its middle
    const fits = width < height === portrait;
    const least = Math.min(across, down);
    const { eye, target } = viewer.pose;
    return [...eye, ...target, fits ? across : least, fits ? down : least];
  };
  const wide = button("This view on wide screens", () => {
    settings.start = view(false);
    editor.changed("The first view on wide screens is set.");
  });
  const high = button("This view on high screens", () => {
    settings.start_portrait = view(true);
    editor.changed("The first view on high screens (phones) is set.");
  });
  const free = make("input", { type: "checkbox", checked: editor.notes.limits === "none" });
  free.style.width = "auto";
  free.addEventListener("change", () => {
    settings.free = free.checked;
    editor.changed();
  });
  return section("First view", [
    hint("Move the camera, then take its view."),
    row(wide, high),
    make("label", {}, "No limits", free),
  ]);
}

/** @param {Editor} editor */
export function upTool(editor) {
  const axes = [...AXES.keys()].map((name) => button(name, () => editor.setUp(AXES.get(name) ?? [0, 0, 1])));
  return section("Upright", [hint("The axis that points up; for any direction, use Floor."), row(...axes)]);
}

/** @param {Editor} editor */
export function annotationTool(editor) {
  const { viewer, settings, element } = editor;
  let list = parsedAnnotations(editor.notes);
  const rows = make("ol");
  const update = (changed = true) => {
    if (changed) {
      settings.annotations = list;
      editor.changed();
    }
    rows.replaceChildren(...list.map(item));
    const root = /** @type {ShadowRoot} */ (element.shadowRoot);
    root.querySelector(".annotations")?.remove();
    if (list.length) new Dots(element, root, viewer, list.map((one) => ({ ...one, text: one.text || "..." })));
  };
  const item = (/** @type {Annotation} */ one, /** @type {number} */ i) => {
    const text = make("textarea", { value: one.text, rows: 2, maxLength: TEXT_MAX, ariaLabel: `Text ${i + 1}` });
    text.addEventListener("input", () => (one.text = text.value));
    text.addEventListener("change", () => update());
    const fly = button("Fly there", () => flyTo(viewer, element, { eye: one.eye ?? viewer.pose.eye, target: one.at }));
    const here = button("Seen from here", () => {
      one.eye = viewer.pose.eye;
      update();
    });
    const gone = button("Delete", () => {
      list = list.filter((other) => other !== one);
      update();
    });
    return make("li", {}, `${i + 1}`, text, row(fly, here, gone));
  };
  const add = button("Add: click a point", () =>
    editor.pick((at) => {
      list = [...list, { at, text: "", eye: viewer.pose.eye }];
      update();
      rows.querySelector(/** @type {"textarea"} */ ("li:last-child textarea"))?.focus();
    }),
  );
  update(false);
  return section("Annotations", [row(add), rows], { closed: () => editor.put() });
}

/** @param {Editor} editor */
export function pathTool(editor) {
  const { viewer, settings, element } = editor;
  let keys = parsedPath(editor.notes);
  let stop = () => {};
  const told = hint("");
  const update = (changed = true) => {
    told.textContent = `${keys.length} key poses. A page with ?autoplay follows them, there and back.`;
    playing.disabled = keys.length < 2;
    if (!changed) return;
    settings.path = keys.map(({ eye, target }) => [...eye, ...target]);
    editor.changed(keys.length === 1 ? "A path needs at least two key poses." : "");
  };
  const add = button("Add this view", () => {
    const { eye, target } = viewer.pose;
    keys = [...keys, { eye, target }];
    update();
  });
  const last = button("Remove the last", () => {
    keys = keys.slice(0, -1);
    update();
  });
  const clear = button("Clear", () => {
    keys = [];
    update();
  });
  const playing = button("Play", () => {
    stop();
    stop = play(viewer, element, keys);
  });
  update(false);
  return section("Camera path", [told, row(add, last, clear, playing)], { closed: () => stop() });
}
