/** Prints as JSON how `decodeMgs` fails in Node.js. Its argument is a file. */

import { readFileSync } from "node:fs";

import { SceneError, decodeMgs } from "mobilegs";

const bytes = readFileSync(process.argv[2]);
const failure = (promise) => promise.then(() => null, (error) => [error.name, error.message, error instanceof SceneError]);
const found = {
  damaged: await failure(decodeMgs(bytes.subarray(0, 700))),
  missing: await failure(decodeMgs(new Response(null, { status: 404 }))),
  nothing: await failure(decodeMgs(3)),
};

// an aborted stream is cancelled, also while it has nothing
const stop = new AbortController();
let cancelled = null;
const silent = new ReadableStream({
  start: (controller) => controller.enqueue(bytes.subarray(0, 700)),
  cancel: (reason) => void (cancelled = reason.message),
});
const waiting = failure(decodeMgs(silent, { signal: stop.signal, onProgress: () => stop.abort(new Error("enough")) }));
found.aborted = await waiting;
found.cancelled = cancelled;
found.before = await failure(decodeMgs(bytes, { signal: AbortSignal.abort(new Error("never")) }));
console.log(JSON.stringify(found));
