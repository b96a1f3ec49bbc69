/** Shares the page's address: by the device's own menu, as a link to copy, and as a QR code. */

import { extras } from "../chunks.js";

const QUIET = 4; // modules around a QR code

/** True if the page has an address that others can open. */
export const shareable = () => location.protocol.startsWith("http");

/**
 * Offer the device's own menu.
 *
 * @param {ShareData} data
 * @returns {Promise<boolean>} whether it was shown, even if the visitor then chose nothing
 */
export async function offer(data) {
  try {
    await navigator.share(data);
    return true;
  } catch (error) {
    return /** @type {Error} */ (error).name === "AbortError";
  }
}

/** True if only this device can open an address. @param {URL | Location} address */
export const isLocal = ({ hostname }) => /^(localhost|127\..*|\[::1\])$/.test(hostname);

/**
 * A QR code as SVG; without an encoder, or for a longer text than it takes, the empty text.
 *
 * @param {string} text
 */
export async function codeOf(text) {
  try {
    const modules = (await extras()).qrCode(text);
    if (!modules) return "";
    const size = modules.length + 2 * QUIET;
    const dark = modules.flatMap((row, y) => row.flatMap((on, x) => (on ? `M${x + QUIET} ${y + QUIET}h1v1h-1z` : [])));
    return `<svg viewBox="0 0 ${size} ${size}"><path d="${dark.join("")}"/></svg>`;
  } catch {
    return "";
  }
}
