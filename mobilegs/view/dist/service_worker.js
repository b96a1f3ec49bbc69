/** Keeps an exported site on the device: it opens offline, and loads again after a change. */

const VERSION = "";
/** Files, each with its SHA-256 or with a text that it must contain. @type {Record<string, string>} */
const FILES = {};

const worker = /** @type {any} */ (self);
// other sites of the same host have their own caches
const PREFIX = `mobilegs ${worker.registration.scope} `;
const NAME = PREFIX + VERSION;

/**
 * Put a file into a cache, unless it has another version: a site may be visited during an upload.
 *
 * @param {Cache} cache
 * @param {string} file
 */
async function keep(cache, file) {
  const response = await fetch(new Request(file, { cache: "no-cache" }));
  const bytes = await response.arrayBuffer();
  const wanted = FILES[file];
  const found = wanted.length === 64 ? await hashOf(bytes) : new TextDecoder().decode(bytes);
  if (!response.ok || !found.includes(wanted)) throw new Error(`${file} has another version`);
  // a new response: browsers do not open pages from redirected responses
  const headers = { "Content-Type": response.headers.get("Content-Type") ?? "" };
  await cache.put(file, new Response(bytes, { headers }));
}

/** SHA-256, in hexadecimal. @param {ArrayBuffer} bytes */
async function hashOf(bytes) {
  const hash = new Uint8Array(await crypto.subtle.digest("SHA-256", bytes));
  return [...hash].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}

worker.addEventListener("install", (/** @type {any} */ event) => {
  event.waitUntil(
    caches
      .open(NAME)
      .then((cache) => Promise.all(Object.keys(FILES).map((file) => keep(cache, file))))
      .then(() => worker.skipWaiting()),
  );
});

worker.addEventListener("activate", (/** @type {any} */ event) => {
  event.waitUntil(
    caches
      .keys()
      .then((names) => names.filter((name) => name.startsWith(PREFIX) && name !== NAME))
      .then((old) => Promise.all(old.map((name) => caches.delete(name))))
      .then(() => worker.clients.claim()),
  );
});

worker.addEventListener("fetch", (/** @type {any} */ event) => {
  if (event.request.method !== "GET") return;
  event.respondWith(
    caches
      .open(NAME)
      .then((cache) => cache.match(event.request, { ignoreSearch: true, ignoreVary: true }))
      .then((/** @type {Response | undefined} */ kept) => kept ?? fetch(event.request)),
  );
});
