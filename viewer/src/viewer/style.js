/** The look of the custom element; it follows the page's light or dark scheme. */
export const STYLE = `
:host {
  display: block; position: relative; overflow: hidden; contain: strict; color-scheme: light dark;
  --paper: #16181dd9; --ink: #f3f4f6; --accent: #7db4ff; --wall: #0d0f12; --field: #ffffff1c;
  background: var(--wall); color: var(--ink);
  font: 14px/1.4 system-ui, sans-serif; min-height: 120px;
}
@media (prefers-color-scheme: light) {
  :host { --paper: #ffffffd9; --ink: #16181d; --accent: #0b62d6; --wall: #e8eaee; --field: #0000000f; }
}
canvas { opacity: 0; display: block; width: 100%; height: 100%; touch-action: none; cursor: grab; outline: none; }
canvas.drawn { opacity: 1; }
canvas.polite { touch-action: pan-y; }
canvas:active { cursor: grabbing; }
canvas.reached { outline: 2px solid var(--accent); outline-offset: -2px; }
.over { position: absolute; inset: 0; pointer-events: none; }
.split {
  position: absolute; top: 0; bottom: 0; width: 20px; margin-left: -10px;
  cursor: ew-resize; touch-action: none; outline: none;
}
.split::before {
  content: ""; position: absolute; inset: 0 9px; background: #fff; box-shadow: 0 0 3px #000a;
}
.split::after {
  content: "\\2039\\2002\\203A"; position: absolute; top: 50%; left: -12px; width: 44px; height: 44px;
  margin-top: -22px; border-radius: 50%; background: var(--paper); line-height: 40px; text-align: center;
  font-size: 20px; box-shadow: 0 0 0 2px #fff, 0 0 5px 2px #000a;
}
.split:focus-visible::after { box-shadow: 0 0 0 3px var(--accent); }
.split span {
  position: absolute; top: 12px; padding: 2px 8px; border-radius: 6px; background: var(--paper);
  max-width: 40vw; overflow: hidden; text-overflow: ellipsis; white-space: nowrap;
}
.split span:first-child { right: 18px; }
.split span:last-child { left: 18px; }
[hidden] { display: none !important; }
.bar { position: absolute; inset: 0 0 auto; height: 3px; background: transparent; }
.bar > div { height: 100%; width: 0; background: var(--accent); transition: width 0.15s; }
.bar.unknown > div { width: 100% !important; animation: wait 1.2s ease-in-out infinite alternate; }
@keyframes wait { from { opacity: 0.2; } }
@media (prefers-reduced-motion: reduce) { .bar > div { transition: none; animation: none !important; } }
.panel {
  position: absolute; background: var(--paper); border-radius: 10px; padding: 12px 16px;
  backdrop-filter: blur(8px);
}
.panel:focus { outline: none; }
.message, .help, .report {
  inset: 0; margin: auto; width: fit-content; height: fit-content; max-width: min(34em, 92%);
  max-height: 92%; box-sizing: border-box; overflow: auto;
}
.message { overflow-wrap: anywhere; }
.stats { top: 12px; left: 12px; font-variant-numeric: tabular-nums; white-space: pre; pointer-events: none; }
.split:not([hidden]) ~ .stats { top: 52px; }
.said { right: 12px; top: 12px; pointer-events: none; }
.said:not(.seen) { clip-path: inset(50%); }
h2 { font-size: 16px; margin: 0 0 8px; }
.help dl { display: grid; grid-template-columns: fit-content(45%) 1fr; gap: 4px 16px; margin: 0 0 12px; }
.help dt { font-weight: 600; }
.help dd { margin: 0; }
.buttons {
  position: absolute; right: 12px; left: 12px; bottom: calc(12px + env(safe-area-inset-bottom));
  display: flex; flex-wrap: wrap; justify-content: end; gap: 8px; pointer-events: none;
}
.settings {
  right: 12px; bottom: calc(68px + env(safe-area-inset-bottom)); width: min(26em, calc(100% - 24px));
  box-sizing: border-box; max-height: calc(100% - 80px); overflow: auto;
}
@media (max-height: 500px) {
  .settings { bottom: 12px; max-height: calc(100% - 24px); columns: 2; width: min(40em, calc(100% - 24px)); }
}
.settings p { display: flex; flex-wrap: wrap; align-items: center; gap: 8px; margin: 0 0 8px; }
.settings p > label { flex: 1; }
.settings > label { display: flex; align-items: center; gap: 8px; min-height: 36px; }
.settings > small { display: block; margin: 8px 0 12px; overflow-wrap: anywhere; }
button, select, [type=color] {
  font: inherit; color: inherit; background: var(--paper); border: 0; border-radius: 10px;
  min-width: 44px; min-height: 44px; padding: 0 9px; cursor: pointer; pointer-events: auto;
}
.panel :is(button, select, [type=color]) { background: var(--field); }
[type=color] { padding: 6px; }
[type=checkbox] { width: 20px; height: 20px; margin: 0; accent-color: var(--accent); }
button:hover { color: var(--accent); }
:is(button, select, input, textarea):focus-visible { outline: 2px solid var(--accent); }
textarea { font: 12px/1.3 ui-monospace, monospace; color: inherit; background: transparent; max-width: 100%; }
.drop { inset: 12px; border: 2px dashed var(--accent); display: grid; place-items: center; }
`;
