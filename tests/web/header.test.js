import assert from "node:assert/strict";
import test from "node:test";

import { SceneError } from "../../viewer/src/mgs/error.js";
import { CLASSIC, parseHeader } from "../../viewer/src/mgs/header.js";
import { smallScene } from "./write.js";

const DEEP = JSON.parse("[".repeat(5000) + "]".repeat(5000));
// what has no text, or none that can be made
const TEXTLESS = { "toString is a number": { toString: 1, length: [] }, "in a list": [{ toString: 1 }], deep: DEEP };

/** Gives a field of the header, by the names on the way to it, another value. */
function put(fields, path, value) {
  const names = path.split(".");
  const last = names.pop();
  names.reduce((inner, name) => inner[name], fields)[last] = value;
}

/** The header of a small scene, its table too. */
function smallFields() {
  const { fields, streams } = smallScene();
  const table = streams.map(([name, codec, data]) => ({ name, codec, bytes: data.length, crc32: 0 }));
  return { ...fields, footprint: CLASSIC, layers: [40], streams: table };
}

function paths(fields) {
  return Object.entries(fields).flatMap(([name, value]) => {
    const inner = value !== null && typeof value === "object" && !Array.isArray(value) ? paths(value) : [];
    return [name, ...inner.map((path) => `${name}.${path}`)];
  });
}

for (const [what, value] of Object.entries(TEXTLESS)) {
  test(`a field without a text form is refused: ${what}`, () => {
    const fields = { colors: "networks", ...smallFields() };
    const { streams, ...others } = fields;
    for (const path of paths(others)) {
      const crafted = structuredClone(fields);
      put(crafted, path, value);
      const refused = (error) => error instanceof SceneError && error.message.length < 200;
      assert.throws(() => parseHeader(crafted, 1e6), refused, path);
    }
  });
}

test("a list instead of a word is reported as a list", () => {
  const fields = smallFields();
  const refusal = (change) => () => parseHeader({ ...fields, ...change }, 1e6);
  assert.throws(refusal({ mode: DEEP }), /has mode 'a list', which this program does not know/);
  assert.throws(refusal({ colors: { toString: 1 } }), /has colors 'an object'/);
  assert.throws(refusal({ mode: null }), /has mode 'null'/);
  assert.throws(refusal({ mode: "x".repeat(50) }), /has mode 'x{40}'/);
  const weighting = { ...fields.weighting, name: { toString: 1 } };
  assert.throws(refusal({ weighting }), /the field 'name' in the header/);
});

test("rotation angles are limited to 8 radians at both ends of a column", () => {
  const { codebooks, ...fields } = { ...smallFields(), mode: "sq", lobes: null };
  const column = (count) => ({ step: 1, least: Array(count).fill(0), size: Array(count).fill(1), middle: Array(count).fill(0) });
  const opens = (least, size, step) => {
    const rotation = { step, least: [0, 0, least], size: [1, 1, size], middle: [0, 0, least] };
    const scalars = { scale: column(3), rotation, appearance: column(6), opacity: column(1) };
    return () => parseHeader({ ...fields, scalars }, 1e6);
  };
  const refused = /the field 'scalars.rotation' in the header/;
  for (const [least, size] of [[-15, 1], [15, 1], [-3, 19], [-15, 2]]) {
    assert.doesNotThrow(opens(least, size, 0.5));
    assert.doesNotThrow(opens(least, size, 0.516129));
    assert.throws(opens(least, size, 0.51613), refused);
  }
  assert.doesNotThrow(opens(0, 1, 16.0000001));
  assert.throws(opens(0, 1, 16.000002), refused);
});

test("the count is limited by the bytes of the streams that are used", () => {
  const fields = smallFields();
  const used = fields.streams.reduce((sum, { bytes }) => sum + bytes, 0);
  const idle = ["spare", "", "view-network", "rotation-finer", "scale.3", "positions@1", "scale.0@0"];
  const streams = [...fields.streams, ...idle.map((name) => ({ name, codec: "raw", bytes: 1e6, crc32: 0 }))];
  const opens = (count) => () => parseHeader({ ...fields, count, footprint: CLASSIC, layers: [count], streams }, 8e6);
  assert.doesNotThrow(opens(used));
  const refused = new RegExp(`claims ${used + 1} Gaussians in ${used} of its 8000000 bytes`);
  assert.throws(opens(used + 1), refused);
});
