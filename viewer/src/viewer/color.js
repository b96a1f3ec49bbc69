/** Parses and writes CSS colours. */

/** @typedef {import("./vector.js").Vector} Vector */

/**
 * @param {string | null} text `ffffff`, `#fff`, or any colour that CSS knows by name
 * @returns {Vector | null} sRGB in [0, 1]; null if it is not a colour
 */
export function colorOf(text) {
  const word = text?.trim().toLowerCase() ?? "";
  const bare = /^([0-9a-f]{3}|[0-9a-f]{6})$/.test(word) ? `#${word}` : word;
  const hex = /^#[0-9a-f]+$/.test(bare) ? bare : named(bare);
  const digits = hex.length === 4 ? hex.replace(/[^#]/g, "$&$&") : hex;
  if (!/^#[0-9a-f]{6}$/.test(digits)) return null;
  const part = (/** @type {number} */ i) => Number.parseInt(digits.slice(i, i + 2), 16) / 255;
  return [part(1), part(3), part(5)];
}

/** @param {Vector} color sRGB in [0, 1] @returns {string} such as `#ff0080` */
export function hexOf(color) {
  const part = (/** @type {number} */ x) => Math.round(255 * Math.min(Math.max(x, 0), 1));
  return `#${color.map((x) => part(x).toString(16).padStart(2, "0")).join("")}`;
}

/** A colour of CSS as a browser writes it: `#rrggbb`, unless it is transparent. @param {string} word */
function named(word) {
  const context = word ? document.createElement("canvas").getContext("2d") : null;
  if (!context) return "";
  // an unknown colour leaves the previous one
  const [black, white] = ["#000000", "#ffffff"].map((before) => {
    context.fillStyle = before;
    context.fillStyle = word;
    return String(context.fillStyle);
  });
  return black === white ? black : "";
}
