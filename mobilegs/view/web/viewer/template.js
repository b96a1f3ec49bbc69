/** What the custom element is made of, and the keys that do what its buttons do. */

import { STYLE } from "./style.js";

const HELP = [
  ["Drag", "turn around the scene"],
  ["Two fingers, right button or Shift", "move sideways"],
  ["Pinch or wheel", "come nearer, go away"],
  ["Double tap", "look at what is there"],
  ["Arrows", "turn"],
  ["W A S D Q E", "fly; with Shift faster"],
  ["M", "orbit, or look around from where you are"],
  ["V", "next of the cameras the scene was taken with"],
  ["R", "back to the beginning"],
  ["F", "full screen"],
  ["P", "save a picture"],
  ["I", "frame rate and size"],
  ["O", "settings"],
  ["H", "this help"],
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
  <button data-act="reset" title="Back to the beginning (R)">Reset</button>
  <button data-act="settings" title="Settings (O)" aria-expanded="false">Settings</button>
  <button data-act="full" title="Full screen (F)">Full screen</button>
  <button data-act="help" title="Help (H)" aria-label="Help" aria-expanded="false">?</button>
</div>
<div class="panel settings" role="dialog" aria-label="Settings" tabindex="-1" hidden>
  <h2>Settings</h2>
  <p><label for="color">Background</label><input id="color" type="color" name="background" />
  <button data-act="own">The scene's own</button></p>
  <p><label for="scale">Resolution</label><select id="scale" name="scale">
    <option value="0">as the device can</option><option value="1">100 %</option>
    <option value="0.7">70 %</option><option value="0.5">50 %</option>
  </select></p>
  <p><label for="mode">Dragging</label><select id="mode" name="mode">
    <option value="orbit">turns the scene</option><option value="fly">looks around</option>
  </select></p>
  <label><input type="checkbox" name="turning" /> Turn slowly by itself</label>
  <label><input type="checkbox" name="stats" /> Show the frame rate</label>
  <small class="device"></small>
  <p><button data-act="open">Open a file</button><input type="file" multiple hidden />
  <button data-act="view">Next camera</button> <button data-act="picture">Save a picture</button>
  <button data-act="close">Close</button></p>
</div>
<div class="panel help" role="dialog" aria-label="Help" tabindex="-1" hidden>
  <h2>Ways to move</h2>
  <dl>${HELP.map(([what, does]) => `<dt>${what}</dt><dd>${does}</dd>`).join("")}</dl>
  <button data-act="close">Close</button>
</div>
<div class="panel report" role="dialog" aria-label="Measured" tabindex="-1" hidden>
  <h2></h2>
  <textarea readonly rows="14" cols="44" aria-label="the figures as JSON"></textarea><br />
  <button data-act="copy">Copy</button> <button data-act="share">Share</button>
  <button data-act="close">Close</button> <small class="copied" role="status"></small>
</div>
<div class="panel message" hidden><p role="alert"></p><button data-act="open">Open a file</button>
<button data-act="close">Close</button></div>
<div class="panel drop" hidden>Drop a scene to open it, or two to compare them</div>`;

export const KEYS = new Map(Object.entries({
  r: "reset", m: "mode", f: "full", h: "help", i: "stats", o: "settings", p: "picture", v: "view",
})); // prettier-ignore
