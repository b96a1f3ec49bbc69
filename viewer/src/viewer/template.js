/** The HTML of the custom element, and its keyboard shortcuts. Its texts are set by `localize`. */

import { icon } from "./icons.js";

/** @typedef {import("./texts.js").Texts} Texts */

/** Gestures and what they do, by names of texts. @type {Record<"touch" | "mouse", [keyof Texts, keyof Texts][]>} */
const GESTURES = {
  touch: [["oneFinger", "rotate"], ["twoFingers", "pan"], ["pinch", "zoom"], ["doubleTap", "focus"]],
  mouse: [["drag", "rotate"], ["rightDrag", "pan"], ["wheel", "zoom"], ["doubleClick", "focus"]],
}; // prettier-ignore
/** Keys and what they do. @type {[string, keyof Texts][]} */
const KEY_HELP = [
  ["← ↑ ↓ →", "rotate"],
  ["W A S D Q E", "flyHelp"],
  ["M", "modeHelp"],
  ["V", "view"],
  ["R", "reset"],
  ["U", "up"],
  ["F", "full"],
  ["P", "picture"],
  ["I", "stats"],
  ["O", "settings"],
  ["H", "help"],
  ["Esc", "close"],
];

/** A button of the bar. @param {"reset" | "share" | "settings" | "help" | "vr" | "ar" | "full"} act @param {string} [more] */
const tool = (act, more = "") => `<button data-act="${act}" data-name="${act}" ${more}>${icon(act)}</button>`;

/** A button with a text. @param {string} act @param {string} [text] @param {string} [more] */
const labelled = (act, text = act, more = "") => `<button data-act="${act}" data-text="${text}" ${more}></button>`;

/** A dialog: at the bottom of phones, at the side elsewhere. @param {string} name @param {string} body */
const sheet = (name, body) => `
<div class="panel sheet ${name}" role="dialog" data-name="${name}" tabindex="-1" hidden>
  <div class="top"><h2 data-text="${name}"></h2>
  <button class="icon" data-act="close" data-name="close">${icon("close")}</button></div>
  <div class="body">${body}</div>
</div>`;

/** @param {"touch" | "mouse"} pointer */
const gestures = (pointer) => `<div class="${pointer}"><h3 data-text="${pointer}"></h3><dl>${GESTURES[pointer]
  .map(([what, does]) => `<dt data-text="${what}"></dt><dd data-text="${does}"></dd>`)
  .join("")}</dl></div>`;

const SHORTCUTS = KEY_HELP.map(([keys, does]) => {
  const caps = keys.split(" ").map((key) => `<kbd>${key}</kbd>`);
  return `<dt>${caps.join(" ")}</dt><dd data-text="${does}"></dd>`;
});

export const TEMPLATE = `
<canvas tabindex="0" role="application"></canvas>
<div class="split" role="slider" tabindex="0" aria-valuemin="0" aria-valuemax="100" hidden>
  <span></span><span></span>
</div>
<slot name="annotation"></slot>
<div class="stick" aria-hidden="true"><span></span></div>
<button class="wake" data-act="wake" data-name="wake" hidden>${icon("wake")}</button>
<div class="bar" role="progressbar" data-name="loading" hidden><div></div></div>
<div class="panel stats" hidden></div>
<div class="panel said" role="status"></div>
<div class="chrome">
  <div class="panel title" hidden><strong dir="auto"></strong><span dir="auto"></span></div>
  <div class="foot">
    <div class="panel hint" aria-hidden="true" hidden>${icon("drag")}<span data-text="hint"></span></div>
    <div class="panel buttons" role="group" data-name="controls">
      ${tool("reset", 'data-key="R"')}
      ${tool("share", 'aria-expanded="false"')}
      ${tool("settings", 'data-key="O" aria-expanded="false"')}
      ${tool("help", 'data-key="H" aria-expanded="false"')}
      ${tool("vr", 'class="vr" hidden')}
      ${tool("ar", 'class="ar" hidden')}
      ${tool("full", 'data-key="F"')}
    </div>
  </div>
</div>
${sheet("settings", `
  <p><label for="mode" data-text="mode"></label><select id="mode" name="mode">
    <option value="orbit" data-text="orbit"></option><option value="fly" data-text="fly"></option>
    <option value="walk" data-text="walk"></option>
  </select></p>
  <p><label for="scale" data-text="scale"></label><select id="scale" name="scale">
    <option value="0" data-text="automatic"></option><option value="1">100 %</option>
    <option value="0.7">70 %</option><option value="0.5">50 %</option>
  </select></p>
  <p><label for="turning" data-text="turning"></label><input id="turning" type="checkbox" name="turning" /></p>
  <p><label for="stats" data-text="stats"></label><input id="stats" type="checkbox" name="stats" /></p>
  <p><label for="color" data-text="background"></label>${labelled("own")}
  <input id="color" type="color" name="background" /></p>
  <div class="acts">${labelled("open")}<input type="file" multiple hidden />
  ${labelled("picture")}${labelled("view")}${labelled("up", "up", 'title="U"')}</div>
  <small class="device"></small>`)}
${sheet("help", `${gestures("touch")}${gestures("mouse")}
  <div class="keys"><h3 data-text="keys"></h3><dl>${SHORTCUTS.join("")}</dl></div>`)}
${sheet("share", `
  <label for="link" data-text="link"></label>
  <p><input id="link" readonly /><button data-act="copy" data-text="copy" class="main"></button></p>
  <small class="copied" role="status"></small>
  <div class="code" role="img" data-name="code"></div>
  <small class="about"></small>
  <div class="acts">${labelled("send")}</div>`)}
${sheet("report", `
  <textarea readonly rows="14" cols="44" data-name="results"></textarea>
  <small class="copied" role="status"></small>
  <div class="acts">${labelled("copy")}${labelled("send")}</div>`)}
<div class="panel message" hidden>${icon("alert")}<h2></h2><p role="alert"></p>
  <div class="acts"><button class="main" data-act="retry" data-text="retry"></button>
  ${labelled("open")}${labelled("close")}</div></div>
<div class="panel drop" data-text="drop" hidden></div>`;

export const KEYS = new Map(Object.entries({
  r: "reset", m: "mode", f: "full", h: "help", i: "stats", o: "settings", p: "picture", v: "view", u: "up",
})); // prettier-ignore
