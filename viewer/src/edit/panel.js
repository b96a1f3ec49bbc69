/** The editor's panel: sections with buttons, sliders and fields. */

export const STYLE = `
#edit { position: fixed; inset: 0 0 0 auto; width: 300px; box-sizing: border-box; overflow-y: auto; padding: 12px;
  background: #15171d; color: #e9ebef; font: 14px/1.4 system-ui, sans-serif; z-index: 2; }
#edit h1 { font-size: 15px; margin: 0 0 8px; overflow-wrap: anywhere; }
#edit details { border-top: 1px solid #333844; }
#edit summary { padding: 10px 0; font-weight: 600; cursor: pointer; }
#edit details > div { display: grid; gap: 8px; padding-bottom: 14px; }
#edit p { margin: 0; color: #b3bac6; font-size: 13px; overflow-wrap: anywhere; }
#edit label { display: grid; grid-template-columns: 76px 1fr; gap: 8px; align-items: center; }
#edit input, #edit textarea, #edit select, #edit button { font: inherit; box-sizing: border-box; min-width: 0; color: inherit; }
#edit input:not([type=range]), #edit textarea, #edit select { width: 100%; padding: 6px 8px; border: 1px solid #454c5a;
  border-radius: 6px; background: #0d0f13; }
#edit input[type=range] { width: 100%; accent-color: #6cb6ff; }
#edit .row { display: flex; flex-wrap: wrap; gap: 6px; }
#edit button { min-height: 34px; padding: 4px 12px; border: 1px solid #454c5a; border-radius: 6px; background: #232833; cursor: pointer; }
#edit button:hover:enabled { background: #2e3543; }
#edit button:disabled { opacity: 0.45; cursor: default; }
#edit button[aria-pressed=true] { border-color: #6cb6ff; background: #1d3a5a; }
#edit .save { position: sticky; bottom: -12px; margin: 0 -12px -12px; padding: 10px 12px; background: #1b1f28; display: grid; gap: 8px;
  border-top: 1px solid #333844; }
#edit .save button.main { background: #1f6feb; border-color: #1f6feb; font-weight: 600; }
#edit :focus-visible { outline: 2px solid #6cb6ff; outline-offset: 1px; }
#edit ol { margin: 0; padding: 0; list-style: none; display: grid; gap: 8px; }
#marks { position: fixed; inset: 0 300px 0 0; z-index: 1; pointer-events: none; }
#marks.drawing { pointer-events: auto; cursor: crosshair; touch-action: none; }
#marks svg { width: 100%; height: 100%; display: block; }
#marks path { fill: none; stroke: #6cb6ff; stroke-width: 2; vector-effect: non-scaling-stroke; }
#marks path.shade { fill: #6cb6ff33; }
mobile-gs { right: 300px !important; }
@media (max-width: 640px) {
  #edit { inset: auto 0 0 0; width: auto; height: 45vh; }
  #marks { inset: 0 0 45vh 0; }
  mobile-gs { right: 0 !important; bottom: 45vh !important; }
}`;

/**
 * An element with properties and children.
 *
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag
 * @param {Partial<Omit<HTMLElementTagNameMap[Tag], "style">>} [properties]
 * @param {(Node | string)[]} children
 * @returns {HTMLElementTagNameMap[Tag]}
 */
export function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

/** @param {string} text @param {() => void} act */
export const button = (text, act) => make("button", { type: "button", textContent: text, onclick: act });

/** Buttons side by side. @param {Node[]} children */
export const row = (...children) => make("div", { className: "row" }, ...children);

/** @param {string} text */
export const hint = (text) => make("p", { textContent: text });

/**
 * A slider with its name.
 *
 * @param {string} name
 * @param {{min: number, max: number, value: number, step?: number}} range
 * @param {() => void} changed
 */
export function slider(name, { min, max, value, step }, changed) {
  const input = make("input", { type: "range", oninput: changed });
  Object.assign(input, { min, max, step: step ?? "any" });
  input.value = String(value);
  return { input, label: make("label", {}, name, input) };
}

/** @param {string} name @param {string} value @param {number} most characters */
export function field(name, value, most) {
  const input = make("input", { value, maxLength: most });
  return { input, label: make("label", {}, name, input) };
}

/**
 * A section that opens; `opened` and `closed` say when its tool is in use.
 *
 * @param {string} title
 * @param {Node[]} children
 * @param {{opened?: () => void, closed?: () => void}} [on]
 */
export function section(title, children, { opened, closed } = {}) {
  const details = make("details", { name: "tool" }, make("summary", { textContent: title }), make("div", {}, ...children));
  details.addEventListener("toggle", () => (details.open ? opened?.() : closed?.()));
  return details;
}
