import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import * as zlib from "node:zlib";
import { readPly } from "../../viewer/src/load/ply.js";
import { isSpz } from "../../viewer/src/load/file_kind.js";
import { readSpz } from "../../viewer/src/load/spz.js";
import { decompressZstd } from "../../viewer/src/load/zstd.js";
import { randomNumbers } from "./pieces.js";
import { COUNT, attributesOf, example, gzippedSpz, headOf, plyOf, streamedSpz } from "./plain.js";
import { joined } from "./write.js";

const C0 = 0.28209479177387814;
// what rounding may change, at most: half a step of each attribute
const STEP = { center: 0.5 / 4096, scale: 1 / 32, opacity: 0.5 / 255, color: 0.5 / 255 / 0.15 };
const SPLAT_TRANSFORM = ["spz_v3.spz", "spz_v4.spz"]; // which keeps 5 and 4 bits of harmonics
const fileOf = (name) => new Uint8Array(readFileSync(new URL(name, import.meta.url)));
const gzipped = (...parts) => new Uint8Array(zlib.gzipSync(joined(parts)));

/** A Zstandard frame without compression. @param {Uint8Array} bytes */
function rawFrame(bytes) {
  const blocks = [];
  for (let at = 0; at === 0 || at < bytes.length; at += 1 << 16) {
    const part = bytes.subarray(at, at + (1 << 16));
    const head = (at + (1 << 16) >= bytes.length ? 1 : 0) | (part.length << 3);
    blocks.push([head & 255, (head >> 8) & 255, head >> 16], part);
  }
  return joined([[0x28, 0xb5, 0x2f, 0xfd, 0, 0x58], ...blocks]);
}

/** @param {number} degree */
function version4(degree) {
  const parts = attributesOf(example(degree), 4).filter((part) => part.length > 0);
  return streamedSpz(COUNT, degree, parts.map(rawFrame), parts.map((part) => part.length));
}

/** Compares a scene with the .ply of the same numbers. @param {any} scene @param {any} plain @param {{turn: number, harmonics: number[]}} steps */
function assertSame(scene, plain, { turn, harmonics }) {
  assert.equal(scene.count, plain.count);
  assert.equal(scene.shSize, plain.shSize);
  assert.ok(scene.sorted && scene.packing === null && scene.lobeSize === 1);
  const opacity = (logit) => 1 / (1 + Math.exp(-logit * C0));
  for (let i = 0; i < plain.count; i++) {
    const [own, other] = [scene, plain].map(({ shapes }) => shapes.subarray(12 * i, 12 * i + 12));
    for (let axis = 0; axis < 3; axis++) {
      const at = 4 * axis;
      assert.ok(Math.abs(own[at + 3] - other[at + 3]) < 1.01 * STEP.center);
      const [a, b] = [own, other].map((shape) => shape.subarray(at, at + 3));
      const [size, expected] = [Math.hypot(...a), Math.hypot(...b)];
      assert.ok(Math.abs(Math.log(size / expected)) < 1.01 * STEP.scale);
      const cosine = a.reduce((sum, part, k) => sum + part * b[k], 0) / (size * expected);
      assert.ok(cosine > Math.cos(turn), `${i}: turned by ${Math.acos(cosine)}`);
    }
    assert.ok(Math.abs(opacity(scene.lobes[2 * i]) - opacity(plain.lobes[2 * i])) < 1.01 * STEP.opacity);
    for (let k = 0; k < plain.shSize; k++) {
      const step = k === 0 ? STEP.color : harmonics[k < 4 ? 0 : 1];
      for (let c = 0; c < 3; c++) {
        const at = 3 * (plain.shSize * i + k) + c;
        assert.ok(Math.abs(scene.colors[at] - plain.colors[at]) < 1.01 * step, `harmonic ${k}`);
      }
    }
  }
}

for (const name of SPLAT_TRANSFORM) {
  test(`${name}, which another program made, is the scene that it was made of`, async () => {
    const scene = await readSpz(fileOf(name));
    assertSame(scene, readPly(plyOf(example())), { turn: 0.004, harmonics: [4.5 / 128, 8.5 / 128] });
  });
}

for (const version of [2, 3, 4]) {
  for (const degree of [0, 1, 2, 3]) {
    test(`version ${version}, degree ${degree}, is read within its steps`, async () => {
      const bytes = version === 4 ? version4(degree) : gzippedSpz(example(degree), version, degree);
      assert.ok(isSpz(bytes));
      const half = 0.5 / 128;
      // bytes for x, y, z leave w unsure where it is small: up to 7 degrees here
      const turn = version === 2 ? 0.12 : 0.004;
      assertSame(await readSpz(bytes), readPly(plyOf(example(degree))), { turn, harmonics: [half, half] });
    });
  }
}

test("version 1 has float16 positions", async () => {
  const [scene, plain] = [await readSpz(gzippedSpz(example(0), 1, 0)), readPly(plyOf(example(0)))];
  for (let i = 3; i < plain.shapes.length; i += 4) {
    assert.ok(Math.abs(scene.shapes[i] - plain.shapes[i]) <= 2 ** -11 * Math.abs(plain.shapes[i]));
  }
});

test("degree 4 is rendered with degree 3", async () => {
  const rows = example(4);
  const [scene, three] = [await readSpz(gzippedSpz(rows, 3, 4)), await readSpz(gzippedSpz(example(3), 3, 3))];
  assert.equal(scene.shSize, 16);
  assert.deepEqual(scene.colors, three.colors);
});

test("opacities of 0 and 1 stay finite", async () => {
  const rows = example(0).map((row, i) => ({ ...row, logit: i % 2 ? 1000 : -1000 }));
  const { lobes, count } = await readSpz(gzippedSpz(rows, 3, 0));
  for (let i = 0; i < count; i++) {
    const opacity = 1 / (1 + Math.exp(-lobes[2 * i] * C0));
    assert.ok(i % 2 ? opacity > 0.99 && opacity < 1 : opacity > 0 && opacity < 1 / 255);
  }
});

test("files name antialiased scenes", async () => {
  const plain = plyOf(example(0));
  const text = new TextDecoder("latin1").decode(plain);
  const commented = (...lines) => {
    const comments = lines.map((line) => `comment ${line}\n`).join("");
    return Uint8Array.from(text.replace("end_header\n", `${comments}end_header\n`), (c) => c.charCodeAt(0));
  };
  const classic = { blur: 0.3, antialiased: false, soft_edge: false };
  assert.deepEqual(readPly(plain).footprint, classic);
  for (const line of ["SplatRenderMode: mip", "antialiased 1", "postshot.anti_aliasing=1"]) {
    assert.deepEqual(readPly(commented(line)).footprint, { ...classic, antialiased: true }, line);
  }
  for (const line of ["SplatRenderMode: default", "antialiased 0", "mobilegs blend sorted"]) {
    assert.deepEqual(readPly(commented(line)).footprint, classic, line);
  }
  const both = readPly(commented("SplatRenderMode: mip", "mobilegs blur 0.1"));
  assert.deepEqual(both.footprint, { ...classic, blur: 0.1, antialiased: true });
  for (const blur of ["0", "5", "-1", "1e1", "x"]) {
    assert.throws(() => readPly(commented(`mobilegs blur ${blur}`)), /a blur that is not possible/, blur);
  }
  const parts = attributesOf(example(0), 3);
  assert.deepEqual((await readSpz(gzipped(headOf(3, COUNT, 0), ...parts))).footprint, classic);
  const { footprint } = await readSpz(gzipped(headOf(3, COUNT, 0, 1), ...parts));
  assert.deepEqual(footprint, { ...classic, antialiased: true });
});

test("a file without Gaussians is a scene without Gaussians", async () => {
  assert.equal((await readSpz(gzipped(headOf(3, 0, 3)))).count, 0);
  assert.equal((await readSpz(streamedSpz(0, 3, [], []))).count, 0);
});

test("extensions are skipped if the header announces them", async () => {
  const parts = attributesOf(example(0), 3);
  const more = new Uint8Array(30);
  const scene = await readSpz(gzipped(headOf(3, COUNT, 0, 2), ...parts, more));
  assert.equal(scene.count, COUNT);
  await assert.rejects(readSpz(gzipped(headOf(3, COUNT, 0), ...parts, more)), /more than it announces/);
  const plain = version4(1);
  const extended = joined([plain.subarray(0, 32).with(14, 2).with(16, 62), more, plain.subarray(32)]);
  assert.deepEqual(await readSpz(extended), await readSpz(plain));
});

const BAD = {
  "another gzip file": [gzipped(new TextEncoder().encode("hello, this is no scene")), /not a \.spz/],
  "an empty gzip file": [gzipped(), /not a \.spz/],
  "a header alone": [headOf(4, 9, 0), /damaged or cut off/],
  "a version to come": [streamedSpz(0, 0, [], []).with(4, 7), /version 7: 1 to 4 are read/],
  "a later version in gzip": [gzipped(headOf(5, 1, 0)), /version 5/],
  "version 4 in gzip": [gzipped(headOf(4, 1, 0), new Uint8Array(99)), /not a \.spz/],
  "a cut": [gzippedSpz(example(), 3, 3).subarray(0, -40), /damaged or cut off/],
  "too few Gaussians": [gzipped(headOf(3, COUNT + 1, 0), ...attributesOf(example(0), 3)), /61 Gaussians were announced/],
  "an absurd number": [gzipped(headOf(3, 2 ** 32 - 1, 3)), /too many/],
  "a large number of nothing": [gzipped(headOf(3, 1e7, 3)), /10000000 Gaussians in \d+ bytes: it is cut off/],
  "an absurd degree": [gzipped(headOf(3, 1, 200)), /damaged/],
  "a bomb": [gzipped(headOf(2, 1, 0), new Uint8Array(1 << 27)), /more than it announces/],
  "streams that are not there": [version4(1).with(15, 9), /damaged/],
  "a stream beyond the end": [version4(1).with(34, 255), /damaged/],
  "a stream that becomes less": [version4(1).with(40, 1), /damaged/],
  "a cut stream": [version4(1).subarray(0, -9), /damaged/],
}; // prettier-ignore

for (const [name, [bytes, sentence]] of Object.entries(BAD)) {
  test(`${name} is refused in one sentence`, async () => {
    await assert.rejects(readSpz(bytes), (error) => {
      assert.match(error.message, sentence);
      return error.constructor === Error && error.message.length < 150;
    });
  });
}

test("mutated files give finite numbers or an error", async () => {
  const random = randomNumbers(5);
  const files = [fileOf("spz_v4.spz"), version4(2), zlib.gunzipSync(fileOf("spz_v3.spz"))];
  let refused = 0;
  for (let round = 0; round < 1500; round++) {
    const bytes = Uint8Array.from(files[round % 3]);
    for (let i = 0; i < 1 + (round % 4); i++) {
      bytes[Math.floor(random() * (round % 2 ? 120 : bytes.length))] = 256 * random();
    }
    try {
      const scene = await readSpz(round % 3 < 2 ? bytes : gzipped(bytes));
      assert.ok([scene.shapes, scene.colors, scene.lobes].every((part) => part.every(Number.isFinite)));
    } catch (error) {
      if (error.constructor !== Error) throw error;
      refused++;
    }
  }
  assert.ok(refused > 500 && refused < 1500, `${refused} of 1500`);
});

const CONTENTS = {
  nothing: new Uint8Array(0),
  "a byte": Uint8Array.of(7),
  zeros: new Uint8Array(500_000),
  "random bytes": new Uint8Array(200_000).map(randomBytes(256)),
  "few symbols": new Uint8Array(300_000).map(randomBytes(5)),
  "many symbols, unevenly": new Uint8Array(300_000).map(randomBytes(256, 4)),
  "small repeats": Uint8Array.from({ length: 150_000 }, (_, i) => (i % 251) * (i % 7)),
  text: new TextEncoder().encode(
    Array.from({ length: 20_000 }, (_, i) => `row ${i * i} of ${(i * 7919) % 1000}\n`).join(""),
  ),
  "a scene": joined(attributesOf(example(), 4)),
};

/** @param {number} values @param {number} [power] */
function randomBytes(values, power = 1) {
  const random = randomNumbers(11);
  return () => Math.floor(values * random() ** power);
}

const skip = "zstdCompressSync" in zlib ? false : "this node has no Zstandard of its own";
for (const [name, content] of Object.entries(CONTENTS)) {
  test(`${name}: decompresses the output of Zstandard at every level`, { skip }, () => {
    for (const level of [-5, 1, 3, 7, 12, 19]) {
      for (const sums of [0, 1]) {
        const { ZSTD_c_compressionLevel, ZSTD_c_checksumFlag } = zlib.constants;
        const params = { [ZSTD_c_compressionLevel]: level, [ZSTD_c_checksumFlag]: sums };
        const packed = new Uint8Array(zlib.zstdCompressSync(content, { params }));
        const found = decompressZstd(packed, content.length);
        assert.ok(Buffer.from(found).equals(Buffer.from(content)), `level ${level}`);
        assert.throws(() => decompressZstd(packed, content.length + 1), Error);
        if (content.length) {
          assert.throws(() => decompressZstd(packed, content.length - 1), /longer than announced/);
          assert.throws(() => decompressZstd(packed.subarray(0, -5), content.length), Error);
        }
      }
    }
  });
}

test("several frames and a skippable one are read", () => {
  const [a, b] = [Uint8Array.of(1, 2, 3), Uint8Array.of(4, 5)];
  const skipped = [0x53, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 9, 9, 9];
  const bytes = joined([rawFrame(a), skipped, rawFrame(b)]);
  assert.deepEqual([...decompressZstd(bytes, 5)], [1, 2, 3, 4, 5]);
  assert.throws(() => decompressZstd(bytes.subarray(0, -1), 5), /damaged/);
});

test("a Zstandard bomb is refused at the announced size", () => {
  const block = [(1 << 1) | 0, 0, 16, 0]; // 131072 zeros, not the last
  const bytes = joined([[0x28, 0xb5, 0x2f, 0xfd, 0, 0x58], ...Array(50_000).fill(block)]);
  assert.throws(() => decompressZstd(bytes, 100_000), /longer than announced/);
});
