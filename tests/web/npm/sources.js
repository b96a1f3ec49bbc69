/**
 * Decodes a file with the package in Node.js from each kind of source.
 *
 * Prints as JSON by kind: whether all arrays equal those from bytes, and what was told of the progress.
 */

import { readFileSync } from "node:fs";

import { decodeMgs } from "mobilegs";

const bytes = readFileSync(process.argv[2]);
const pieces = () =>
  new ReadableStream({
    start(controller) {
      for (let at = 0; at < bytes.length; at += 997) controller.enqueue(bytes.subarray(at, at + 997));
      controller.close();
    },
  });
const SOURCES = {
  buffer: () => bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length),
  blob: () => new Blob([bytes]),
  stream: pieces,
  response: () => new Response(pieces()),
  address: () => `data:application/octet-stream;base64,${bytes.toString("base64")}`,
};
const expected = await decodeMgs(bytes);
const found = {};
for (const [kind, source] of Object.entries(SOURCES)) {
  const told = [];
  const scene = await decodeMgs(source(), { onProgress: (progress) => told.push(progress) });
  found[kind] = { equal: JSON.stringify(scene) === JSON.stringify(expected), told };
}
console.log(JSON.stringify({ size: bytes.length, found }));
