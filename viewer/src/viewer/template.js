/** The HTML of the custom element, and its keyboard shortcuts. */

import { STYLE } from "./style.js";

const HELP = [
  ["Drag", "rotate the scene"],
  ["Two fingers, right button or Shift", "move sideways"],
  ["Pinch or wheel", "zoom in and out"],
  ["Double tap", "look at that point"],
  ["Arrow keys", "rotate"],
  ["W A S D Q E", "fly; hold Shift to fly faster"],
  ["M", "switch between orbiting and looking around"],
  ["V", "next training camera"],
  ["R", "back to the first view"],
  ["U", "turn another axis upwards"],
  ["F", "full screen"],
  ["P", "save a picture"],
  ["I", "frame rate and size"],
  ["O", "settings"],
  ["H", "help"],
];

export const TEMPLATE = `
<style>${STYLE}</style>
<canvas tabindex="0" role="application"></canvas>
<div class="split" role="slider" tabindex="0" aria-valuemin="0" aria-valuemax="100" hidden>
  <span></span><span></span>
</div>
<div class="bar" role="progressbar" aria-label="loading" hidden><div></div></div>
<div class="panel stats" hidden></div>
<div class="panel said" role="status"></div>
<div class="buttons">
  <button data-act="reset" title="Back to the first view (R)">Reset</button>
  <button data-act="settings" title="Settings (O)" aria-expanded="false">Settings</button>
  <button data-act="full" title="Full screen (F)">Full screen</button>
  <button data-act="help" title="Help (H)" aria-label="Help" aria-expanded="false">?</button>
</div>
<div class="panel settings" role="dialog" aria-label="Settings" tabindex="-1" hidden>
  <h2>Settings</h2>
  <p><label for="color">Background</label><input id="color" type="color" name="background" />
  <button data-act="own">The scene's own</button></p>
  <p><label for="scale">Resolution</label><select id="scale" name="scale">
    <option value="0">automatic</option><option value="1">100 %</option>
    <option value="0.7">70 %</option><option value="0.5">50 %</option>
  </select></p>
  <p><label for="mode">Dragging</label><select id="mode" name="mode">
    <option value="orbit">rotates the scene</option><option value="fly">looks around</option>
  </select></p>
  <label><input type="checkbox" name="turning" /> Rotate slowly</label>
  <label><input type="checkbox" name="stats" /> Show the frame rate</label>
  <small class="device"></small>
  <p><button data-act="open">Open a file</button><input type="file" multiple hidden />
  <button data-act="view">Next camera</button> <button data-act="picture">Save a picture</button>
  <button data-act="up" title="Another axis points up (U)">Turn upright</button>
  <button data-act="close">Close</button></p>
</div>
<div class="panel help" role="dialog" aria-label="Help" tabindex="-1" hidden>
  <h2>Controls</h2>
  <dl>${HELP.map(([what, does]) => `<dt>${what}</dt><dd>${does}</dd>`).join("")}</dl>
  <button data-act="close">Close</button>
</div>
<div class="panel report" role="dialog" aria-label="Benchmark" tabindex="-1" hidden>
  <h2></h2>
  <textarea readonly rows="14" cols="44" aria-label="Results as JSON"></textarea><br />
  <button data-act="copy">Copy</button> <button data-act="share">Share</button>
  <button data-act="close">Close</button> <small class="copied" role="status"></small>
</div>
<div class="panel message" hidden><p role="alert"></p><button data-act="open">Open a file</button>
<button data-act="close">Close</button></div>
<div class="panel drop" hidden>Drop a scene to open it, or two to compare them</div>`;

export const KEYS = new Map(Object.entries({
  r: "reset", m: "mode", f: "full", h: "help", i: "stats", o: "settings", p: "picture", v: "view", u: "up",
})); // prettier-ignore
