/** Keeps an exported site on the device: it opens without a network, and anew after a change. */

const VERSION = "";
/** @type {string[]} */
const FILES = [];

const worker = /** @type {any} */ (self);
// other sites of the same host have caches of their own, which are not ours to touch
const PREFIX = `mobilegs ${worker.registration.scope} `;
const NAME = PREFIX + VERSION;

worker.addEventListener("install", (/** @type {any} */ event) => {
  event.waitUntil(
    caches
      .open(NAME)
      .then((cache) => cache.addAll(FILES.map((file) => new Request(file, { cache: "reload" }))))
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
      .then((cache) => cache.match(event.request, { ignoreSearch: true }))
      .then((/** @type {Response | undefined} */ kept) => kept ?? fetch(event.request)),
  );
});
