/** The look of the custom element. Panels follow the visitor's light or dark scheme; the stage is dark. */
export const STYLE = `
:host {
  display: block; position: relative; overflow: hidden; contain: strict; container-type: size;
  color-scheme: light dark; min-height: 120px; background: #0d0f12; color: var(--ink);
  --paper: #15171ce6; --ink: #f3f4f6; --dim: #c3c8d0; --line: #ffffff26; --field: #ffffff1f; --accent: #8ab8ff; --on: #0d1420;
  font: 15px/1.45 system-ui, sans-serif; -webkit-text-size-adjust: 100%; -webkit-tap-highlight-color: transparent;
  --top: calc(12px + env(safe-area-inset-top)); --bottom: calc(12px + env(safe-area-inset-bottom));
  --start: calc(12px + env(safe-area-inset-left)); --end: calc(12px + env(safe-area-inset-right));
}
:host(:dir(rtl)) { --start: calc(12px + env(safe-area-inset-right)); --end: calc(12px + env(safe-area-inset-left)); }
@media (prefers-color-scheme: light) {
  :host { --paper: #fffffff0; --ink: #16181d; --dim: #474d58; --line: #0000001f; --field: #00000012; --accent: #0b57c9; --on: #fff; }
}
[hidden] { display: none !important; }
canvas { opacity: 0; display: block; width: 100%; height: 100%; touch-action: none; cursor: grab; outline: none; }
canvas.drawn { opacity: 1; transition: opacity 0.3s; }
canvas.polite { touch-action: pan-y; }
canvas:active { cursor: grabbing; }
canvas.reached { outline: 2px solid var(--accent); outline-offset: -2px; }
.over { position: absolute; inset: 0; pointer-events: none; }
.panel {
  position: absolute; box-sizing: border-box; background: var(--paper); border-radius: 14px; padding: 12px 16px;
  box-shadow: 0 0 0 1px var(--line), 0 6px 24px #0003; backdrop-filter: blur(12px);
}
.panel:focus { outline: none; }
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
  position: absolute; top: var(--top); padding: 2px 8px; border-radius: 6px; background: var(--paper);
  max-width: 40cqw; overflow: hidden; text-overflow: ellipsis; white-space: nowrap;
}
.split span:first-child { right: 18px; }
.split span:last-child { left: 18px; }
slot { display: block; position: absolute; inset: 0; overflow: hidden; pointer-events: none; }
::slotted(*) {
  position: absolute; left: var(--annotation-x, 0); top: var(--annotation-y, 0); translate: -50% -50%; pointer-events: auto;
}
::slotted([data-outside]) { visibility: hidden; }
.bar { position: absolute; inset: 0 0 auto; height: 3px; background: #0006; }
.bar > div { height: 100%; width: 0; background: #8ab8ff; transition: width 0.15s; }
.bar.unknown > div { width: 100% !important; animation: wait 1.2s ease-in-out infinite alternate; }
@keyframes wait { from { opacity: 0.2; } }
.stats {
  top: var(--top); inset-inline-end: var(--end); padding: 8px 12px; font: 12px/1.5 ui-monospace, monospace;
  white-space: pre; unicode-bidi: plaintext; pointer-events: none;
}
.split:not([hidden]) ~ .stats { top: calc(var(--top) + 40px); }
.said {
  top: var(--top); inset-inline: var(--start) var(--end); width: fit-content; max-width: calc(100% - 24px);
  margin-inline: auto; padding: 8px 14px; pointer-events: none;
}
.said:not(.seen) { clip-path: inset(50%); }
.chrome { position: absolute; inset: 0; pointer-events: none; transition: inset 0.2s; }
.title {
  top: var(--top); inset-inline-start: var(--start); max-width: min(24em, calc(100% - 24px)); padding: 8px 14px;
  overflow-wrap: anywhere; transition: opacity 0.4s;
}
.title > * { display: block; }
.title span { color: var(--dim); font-size: 13px; }
.split:not([hidden]) ~ .chrome .title { display: none; }
.foot {
  position: absolute; bottom: var(--bottom); inset-inline: var(--start) var(--end); pointer-events: none;
  display: flex; flex-direction: column; align-items: center; gap: 12px;
}
.foot > * { position: static; display: flex; align-items: center; }
.buttons { flex-wrap: wrap; justify-content: center; padding: 4px; gap: 2px; pointer-events: auto; transition: opacity 0.4s; }
.hint { gap: 10px; padding: 8px 16px; animation: rise 0.4s; }
.hint svg { color: var(--accent); flex: none; }
.idle:not(:has([aria-expanded=true])) :is(.title, .buttons):not(:has(:focus-visible)) { opacity: 0; }
@media (hover: none) { .idle:not(:has([aria-expanded=true])) .buttons { pointer-events: none; } }
@media (hover: hover) { .buttons:hover { opacity: 1 !important; } }
.sheet, .message { display: flex; flex-direction: column; padding: 0; animation: rise 0.2s; }
.sheet {
  top: var(--top); bottom: var(--bottom); inset-inline-end: var(--end); margin-top: auto;
  width: min(380px, calc(100% - 24px)); height: fit-content; max-height: calc(100% - 24px);
}
.report { width: min(34em, calc(100% - 24px)); }
.top { display: flex; align-items: center; justify-content: space-between; padding-block: 8px 4px; padding-inline: 20px 8px; }
.body { overflow: auto; overscroll-behavior: contain; padding: 0 20px 20px; }
@keyframes rise { from { opacity: 0; translate: 0 12px; } }
@container (min-width: 640px) {
  .chrome:has([aria-expanded=true]) { inset-inline-end: 392px; }
}
@container (max-width: 639.9px) {
  .sheet {
    inset: auto 0 0; width: auto; max-height: min(72%, 100% - 48px); border-radius: 20px 20px 0 0;
    padding-bottom: env(safe-area-inset-bottom);
  }
}
.message {
  inset: 0; margin: auto; width: fit-content; height: fit-content; max-width: min(30em, 100% - 24px); max-height: 94%;
  padding: 20px; gap: 10px; overflow: auto; overflow-wrap: anywhere;
}
.message > svg { color: var(--accent); width: 30px; height: 30px; flex: none; }
.message p { margin: 0; color: var(--dim); }
h2 { font-size: 17px; line-height: 1.3; margin: 0; }
h3 { font-size: 13px; font-weight: 600; color: var(--dim); margin: 12px 0 6px; }
.help .body > :first-child h3 { margin-top: 0; }
dl { display: grid; grid-template-columns: fit-content(45%) 1fr; gap: 6px 16px; margin: 0; }
dt { font-weight: 600; }
dd { margin: 0; color: var(--dim); }
dd::first-letter { text-transform: uppercase; }
kbd { font: 12px/1.6 ui-monospace, monospace; padding: 1px 6px; border-radius: 5px; background: var(--field); white-space: nowrap; }
@container (max-width: 300px) {
  dl { display: block; }
  dd { margin-bottom: 8px; }
}
.touch, .mouse, .keys { display: none; }
@media (any-pointer: coarse) { .touch { display: block; } }
@media (any-pointer: fine) { .mouse, .keys { display: block; } }
.typed .keys { display: block; }
.sheet p { display: flex; flex-wrap: wrap; align-items: center; gap: 8px; margin: 0; min-height: 52px; }
.sheet p > label { flex: 1 1 5em; }
.sheet p + p { border-top: 1px solid var(--line); }
.sheet p > input:not([type]) { flex: 1; min-width: 0; }
.acts { display: flex; flex-wrap: wrap; gap: 8px; }
.body > .acts { margin-top: 12px; }
.acts > * { flex: 1 0 auto; }
small { display: block; font-size: 13px; color: var(--dim); overflow-wrap: anywhere; margin-top: 8px; }
small:empty { display: none; }
.code { background: #fff; border-radius: 10px; width: min(196px, 100%); margin: 12px auto 0; }
.code svg { display: block; width: 100%; height: auto; fill: #000; stroke: none; shape-rendering: crispEdges; }
.about { text-align: center; }
svg { width: 24px; height: 24px; fill: none; stroke: currentColor; stroke-width: 1.8; stroke-linecap: round; stroke-linejoin: round; }
button, select, input:not([type]), [type=color] {
  font: inherit; color: inherit; background: var(--field); border: 0; border-radius: 10px; box-sizing: border-box;
  min-width: 44px; min-height: 44px; padding: 0 12px; max-width: 100%; touch-action: manipulation;
}
button, select, [type=color], [type=checkbox] { cursor: pointer; }
select, input:not([type]) { font-size: 16px; }
.buttons button, .icon { display: grid; place-items: center; padding: 0; width: 44px; background: none; }
.buttons :is([aria-expanded=true], [aria-pressed=true]) { background: var(--field); color: var(--accent); }
.main { background: var(--accent); color: var(--on); }
[type=color] { padding: 8px; width: 52px; }
[type=checkbox] {
  appearance: none; position: relative; width: 46px; height: 28px; margin: 0; border-radius: 14px; background: var(--field);
  box-shadow: inset 0 0 0 1.5px var(--dim);
}
[type=checkbox]::before {
  content: ""; position: absolute; inset-block: 5px; inset-inline-start: 5px; width: 18px; border-radius: 9px;
  background: var(--dim); transition: inset-inline-start 0.15s;
}
[type=checkbox]:checked { background: var(--accent); box-shadow: none; }
[type=checkbox]:checked::before { inset-inline-start: 23px; background: var(--on); }
@media (forced-colors: active) { [type=checkbox] { appearance: auto; } }
@media (hover: hover) {
  button:hover { background: var(--field); color: var(--accent); }
  .main:hover { background: var(--accent); color: var(--on); filter: brightness(1.1); }
}
:is(button, select, input, textarea):focus-visible { outline: 2px solid var(--accent); outline-offset: 1px; }
textarea {
  font: 12px/1.3 ui-monospace, monospace; color: inherit; background: var(--field); border: 0; border-radius: 10px;
  box-sizing: border-box; width: 100%; padding: 10px; direction: ltr;
}
.still { opacity: 1; position: absolute; inset: 0; width: 100%; height: 100%; pointer-events: none; }
.wake {
  position: absolute; inset: 0; margin: auto; width: 72px; height: 72px; border-radius: 50%; background: var(--paper);
}
.stick {
  position: absolute; inset-block-end: calc(var(--bottom) + 64px); inset-inline-start: var(--start); width: 120px;
  height: 120px; border-radius: 50%; background: #0006; box-shadow: inset 0 0 0 2px #fff9; touch-action: none;
}
.stick:not(.shown) { display: none; }
.stick span { position: absolute; inset: 34px; border-radius: 50%; background: #fffd; box-shadow: 0 1px 6px #0008; }
@media (not (any-pointer: coarse)) { .stick { display: none; } }
.drop { inset: 12px; border: 2px dashed var(--accent); display: grid; place-items: center; text-align: center; }
@media (prefers-reduced-motion: reduce) { *, ::before { transition: none !important; animation: none !important; } }
`;

/** Give a shadow tree a style, which also policies without `style-src 'unsafe-inline'` allow. @param {ShadowRoot} root */
export function adoptStyle(root, text = STYLE) {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  root.adoptedStyleSheets.push(sheet);
}
