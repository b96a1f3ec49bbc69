/** Lanes of rANS streams in WebAssembly against JavaScript, on sound and on damaged streams. */

import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";

import { ContainerReader } from "../../viewer/src/mgs/container.js";
import { parseHeader } from "../../viewer/src/mgs/header.js";
import { decodeRans, laneCount } from "../../viewer/src/mgs/rans.js";
import { randomNumbers } from "./pieces.js";
import { bits, rans } from "./write.js";

const FOLDER = new URL("../mgs/conformance/", import.meta.url);

const CLASSES = 49; // of positions

/** Every rANS stream of indices or of positions' classes in the conformance files. */
function* streams() {
  for (const file of readdirSync(FOLDER).filter((name) => name.endsWith(".mgs"))) {
    const bytes = new Uint8Array(readFileSync(new URL(file, FOLDER)));
    const container = new ContainerReader();
    const found = container.append(bytes);
    if (container.fields.sh_degree !== 1) continue; // a header that the viewer refuses
    const { cuts, scalars, lodSizes } = parseHeader(container.fields, container.total);
    for (const { name, codec, data } of found) {
      const [, attribute, column, level = 0] = /^([\w-]+)(?:\.(\d+))?(?:@(\d+))?$/.exec(name);
      const own = { name: `${file} ${name}`, count: lodSizes[level] };
      if (codec === "morton-class") {
        const coded = new DataView(data.buffer, data.byteOffset).getUint32(0, true);
        yield { ...own, data: data.subarray(4, 4 + coded), size: CLASSES };
      }
      if (codec !== "rans") continue;
      const size = cuts.get(attribute)?.size ?? scalars.get(attribute).columns[column].size;
      yield { ...own, data, size };
    }
  }
}

/** A stream of which every symbol makes another one likely: three symbols, a half or a quarter each. */
function contextualStream(count) {
  const random = randomNumbers(3);
  const quarters = [[2, 1, 1], [1, 2, 1], [1, 1, 2]];
  const lanes = laneCount(count);
  const [short, longer] = [Math.floor(count / lanes), count % lanes];
  const first = (lane) => lane * short + Math.min(lane, longer);
  const symbols = Array.from({ length: count }, () => Math.floor(3 * random()));
  const states = Array(lanes).fill(65536);
  const words = [];
  // a decoder's way backwards
  for (let step = short; step >= 0; step--) {
    for (let lane = (step < short ? lanes : longer) - 1; lane >= 0; lane--) {
      const place = first(lane) + step;
      const row = quarters[step ? symbols[place - 1] : 0];
      const frequency = 4096 * row[symbols[place]];
      const start = 4096 * row.slice(0, symbols[place]).reduce((a, b) => a + b, 0);
      if (states[lane] >= frequency * 2 ** 18) {
        words.push(states[lane] % 65536);
        states[lane] = Math.floor(states[lane] / 65536);
      }
      states[lane] = Math.floor(states[lane] / frequency) * 16384 + (states[lane] % frequency) + start;
    }
  }
  // used, all three occur, 13 digits, and the frequencies of the first two, less one
  const tables = quarters.flatMap(([a, b]) => [
    [1, 1], [7, 3], [13, 4], [1, 1], [4096 * a - 1, 13], [1, 1], [4096 * b - 1, 13],
  ]); // prettier-ignore
  return { symbols, data: rans(3, 3, bits(tables), states, words.reverse()) };
}

/** What comes out, or what is said instead. */
function outcome(data, count, size, plain) {
  try {
    return decodeRans(data, count, size, plain);
  } catch (error) {
    return String(error);
  }
}

test("WebAssembly decodes the same symbols as JavaScript", () => {
  let seen = 0;
  for (const { name, data, count, size } of streams()) {
    assert.deepEqual(decodeRans(data, count, size), decodeRans(data, count, size, true), name);
    seen++;
  }
  assert.ok(seen > 50, `${seen} streams`);
  for (const count of [1, 4095, 4096, 20_001]) {
    const { symbols, data } = contextualStream(count);
    for (const plain of [false, true]) assert.deepEqual([...decodeRans(data, count, 3, plain)], symbols);
  }
});

test("damaged streams give the same error with and without WebAssembly, and change no later result", () => {
  const random = randomNumbers(7);
  const { data: contextual } = contextualStream(5000);
  const sound = [...streams(), { name: "contexts", data: contextual, count: 5000, size: 3 }];
  const said = new Set();
  for (let round = 0; round < 3000; round++) {
    const { name, data, count, size } = sound[round % sound.length];
    const broken = data.slice();
    // behind the tables: what is told of them is refused before any lane runs
    const from = round % 3 ? 12 + new DataView(data.buffer, data.byteOffset).getUint32(4, true) : 0;
    broken[from + Math.floor(random() * (broken.length - from))] ^= 1 + Math.floor(255 * random());
    const plain = outcome(broken, count, size, true);
    assert.deepEqual(outcome(broken, count, size, false), plain, name);
    if (typeof plain === "string") said.add(plain);
    assert.deepEqual(decodeRans(data, count, size), decodeRans(data, count, size, true), name);
  }
  for (const part of ["ends early", "where it should"]) {
    assert.ok([...said].some((sentence) => sentence.includes(part)), part);
  }
});
