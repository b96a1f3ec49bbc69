/** Shares the page's address, by the device's own menu, as a link to copy and as a QR code; and saves pictures. */

import { own } from "../assets.js";

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
    return (await own(import("./extras.js"))).svgCode(text);
  } catch {
    return "";
  }
}

/** Save a picture as a file. @param {Blob | null | undefined} picture */
export function save(picture) {
  if (!picture) return;
  const link = document.createElement("a");
  Object.assign(link, { href: URL.createObjectURL(picture), download: "scene.png" }).click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
