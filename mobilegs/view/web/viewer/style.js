/** The look of the custom element; it follows the page's light or dark scheme. */
export const STYLE = `
:host {
  display: block; position: relative; overflow: hidden; contain: strict; color-scheme: light dark;
  --paper: #16181dd9; --ink: #f3f4f6; --accent: #7db4ff; --wall: #0d0f12;
  background: var(--wall); color: var(--ink);
  font: 14px/1.4 system-ui, sans-serif; min-height: 120px;
}
@media (prefers-color-scheme: light) {
  :host { --paper: #ffffffd9; --ink: #16181d; --accent: #0b62d6; --wall: #e8eaee; }
}
canvas { opacity: 0; display: block; width: 100%; height: 100%; touch-action: none; cursor: grab; outline: none; }
canvas.drawn { opacity: 1; }
canvas:active { cursor: grabbing; }
canvas:focus-visible { box-shadow: inset 0 0 0 2px var(--accent); }
[hidden] { display: none !important; }
.bar { position: absolute; inset: 0 0 auto; height: 3px; background: transparent; }
.bar > div { height: 100%; width: 0; background: var(--accent); transition: width 0.15s; }
.panel {
  position: absolute; background: var(--paper); border-radius: 10px; padding: 12px 16px;
  backdrop-filter: blur(8px);
}
.message { inset: 0; margin: auto; width: fit-content; height: fit-content; max-width: 30em; }
.stats { top: 12px; left: 12px; font-variant-numeric: tabular-nums; white-space: pre; pointer-events: none; }
.help { inset: 0; margin: auto; width: fit-content; height: fit-content; max-height: 80%; overflow: auto; }
.help h2 { font-size: 16px; margin: 0 0 8px; }
.help dl { display: grid; grid-template-columns: auto 1fr; gap: 4px 16px; margin: 0; }
.help dt { font-weight: 600; }
.help dd { margin: 0; }
.buttons { position: absolute; right: 12px; bottom: calc(12px + env(safe-area-inset-bottom)); display: flex; gap: 8px; }
button {
  font: inherit; color: inherit; background: var(--paper); border: 0; border-radius: 10px;
  min-width: 44px; min-height: 44px; padding: 0 12px; cursor: pointer;
}
button:hover { color: var(--accent); }
button:focus-visible { outline: 2px solid var(--accent); }
.report { inset: 0; margin: auto; width: fit-content; height: fit-content; max-width: 92%; }
.report h2 { font-size: 16px; margin: 0 0 8px; }
textarea { font: 12px/1.3 ui-monospace, monospace; color: inherit; background: transparent; max-width: 100%; }
.drop { inset: 12px; border: 2px dashed var(--accent); display: grid; place-items: center; }
`;
