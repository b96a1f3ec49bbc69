/** Words of a block of Gaussians, four at a time: what `defined` of pack.js does, by WebAssembly. */

import {
  BELOW, F32, I32, PLUS, SHIFT_LEFT, TIMES, V128, advance, assembled, floats, get, integers, load, loop, number, set,
  simd, storeLane,
} from "../mgs/assembler.js"; // prettier-ignore

const and = simd(0x4e);
const or = simd(0x50);
const select = simd(0x52); // where all bits of the third are set, the first
const sameInteger = simd(0x37);
const belowInteger = simd(0x39);
const notAboveInteger = simd(0x3d);
const shiftedLeft = simd(0xab);
const shifted = simd(0xad);
const sum = simd(0xae);
const difference = simd(0xb1);
const leastInteger = simd(0xb6);
const largestInteger = simd(0xb8);
const whole = simd(0xf8);
const float = simd(0xfa);
const splat = simd(0x13);
const below = simd(0x43);
const above = simd(0x44);
const nearest = simd(0x6a);
const absolute = simd(0xe0);
const plus = simd(0xe4);
const minus = simd(0xe5);
const times = simd(0xe6);
const divided = simd(0xe7);
const least = simd(0xe8);
const largest = simd(0xe9);
const LANES = [0, 1, 2, 3];

/** @param {number[]} value @param {number[]} low @param {number[]} high */
const between = (value, low, high) => least(largest(value, low), high);

/**
 * `pack(scales, quats, sh, lobes, words, pairs, stride, leastBits, growBits)` takes places in bytes,
 * pairs of columns behind the first, and words of the lobes of a Gaussian.
 *
 * @param {import("./pack.js").Constants} constants
 */
function packBody({ block, steps, turn, invisible, leastScale }) {
  const [scales, quats, sh, lobes, words, pairs, stride, leastBits, growBits] = [0, 1, 2, 3, 4, 5, 6, 7, 8];
  const [row, at, end, out0, out1, out2, out3] = [9, 10, 11, 12, 13, 14, 15];
  const outs = [out0, out1, out2, out3];
  const [a, b, byte, grow, phiByte, phiGrow, word, x, most, phiMost, lost] = Array.from(Array(11), (_, i) => 16 + i);
  const rowBytes = 4 * block;
  const column = (/** @type {number} */ i) => load(get(at), i * rowBytes);
  const to = (/** @type {number} */ base) => [...get(base), ...get(row), PLUS, ...set(at)];
  /** Leaves the half's bits next to the number in `x`. */
  const half = [
    ...and(get(x), integers(0x7fffffff)), ...set(b),
    ...or(
      and(shifted(get(x), number(16)), integers(0x8000)),
      select(
        whole(nearest(times(get(b), floats(2 ** 24)))),
        leastInteger(
          shifted(
            difference(
              sum(sum(get(b), integers(0xfff)), and(shifted(get(b), number(13)), integers(1))),
              integers(0x38000000),
            ),
            number(13),
          ),
          integers(0x7bff),
        ),
        belowInteger(get(b), integers(0x38800000)),
      ),
    ),
  ];
  const halves = (/** @type {number} */ first, /** @type {number} */ second) => [
    ...column(second), ...set(x), ...half, ...set(a),
    ...column(first), ...set(x), ...or(half, shiftedLeft(get(a), number(16))),
  ];
  /** The scale's byte of the largest number, and what brings it to 127. */
  const scale = (/** @type {number} */ most, /** @type {number} */ byte, /** @type {number} */ grow) => [
    ...difference(shifted(sum(get(most), integers(0xfffff)), number(20)), integers(leastScale)), ...set(byte),
    ...leastInteger(largestInteger(get(byte), integers(0)), integers(255)), ...set(byte),
    ...divided(floats(127), shiftedLeft(sum(get(byte), integers(leastScale)), number(20))), ...set(grow),
  ];
  const rounded = (/** @type {number} */ grow, /** @type {number[]} */ value) =>
    and(whole(plus(between(times(get(grow), value), floats(-127), floats(127)), floats(512.5))), integers(255));
  const more = (/** @type {number} */ most, /** @type {number[]} */ value) => [
    ...largest(get(most), absolute(value)), ...set(most),
  ];
  /** Four words to places that are as far apart as the words of a Gaussian are long. */
  const stored = (/** @type {number[]} */ value, /** @type {number} */ place) => [
    ...value, ...set(word),
    ...LANES.flatMap((lane) => storeLane([...get(words), ...get(row), ...number(2), SHIFT_LEFT, PLUS], get(word), lane, 4 * (place + 4 * lane))),
  ];

  const color = [
    ...to(sh), ...floats(0), ...set(most),
    ...Array.from(Array(9), (_, i) => more(most, column(3 + i))).flat(),
    ...scale(most, byte, grow),
    ...stored(halves(0, 1), 4 * block),
    ...column(2), ...set(x),
    ...stored(
      or(or(half, shiftedLeft(get(byte), number(16))), shiftedLeft(rounded(grow, column(3)), number(24))),
      4 * block + 1,
    ),
    ...[0, 1].flatMap((i) => {
      const [first, ...others] = LANES.map((j) => rounded(grow, column(4 + 4 * i + j)));
      const all = others.reduce((all, one, j) => or(all, shiftedLeft(one, number(8 * j + 8))), first);
      return stored(all, 4 * block + 2 + i);
    }),
  ];

  const pair = (/** @type {number} */ i) =>
    or(rounded(grow, column(i)), shiftedLeft(rounded(phiGrow, column(i + 1)), number(8)));
  const overPairs = (/** @type {number} */ step, /** @type {number[]} */ body) => [
    ...to(lobes), ...advance(at, 2 * rowBytes),
    ...get(at), ...get(pairs), ...number(2 * rowBytes), TIMES, PLUS, ...set(end),
    ...get(pairs), 0x04, 0x40,
    ...loop([...body, ...advance(at, step * rowBytes)], [...get(at), ...get(end), BELOW]),
    0x0b,
  ];
  const everyOut = (/** @type {number[]} */ value) => [
    ...value, ...set(word), ...outs.flatMap((out, lane) => [...storeLane(get(out), get(word), lane), ...advance(out, 4)]),
  ];
  const lobe = [
    ...get(words), ...number(8 * rowBytes), PLUS, ...get(row), ...get(stride), TIMES, PLUS, ...set(out0),
    ...[0, 1, 2].flatMap((i) => [...get(outs[i]), ...get(stride), ...number(2), SHIFT_LEFT, PLUS, ...set(outs[i + 1])]),
    ...floats(0), ...set(most), ...floats(0), ...set(phiMost),
    ...overPairs(2, [...more(most, column(0)), ...more(phiMost, column(1))]),
    ...scale(most, byte, grow),
    ...scale(phiMost, phiByte, phiGrow),
    ...to(lobes),
    ...halves(0, 1), ...set(x),
    ...everyOut(
      select(or(and(get(x), difference(integers(0), integers(65536))), integers(invisible)), get(x), get(lost)),
    ),
    ...overPairs(4, everyOut(or(pair(0), shiftedLeft(pair(2), number(16))))),
    ...stored(shiftedLeft(or(get(byte), shiftedLeft(get(phiByte), number(8))), number(16)), 1),
  ];

  const size = (/** @type {number} */ axis) => {
    const share = times(minus(float(column(axis)), splat(get(leastBits))), splat(get(growBits)));
    return whole(plus(times(floats(steps[axis]), between(share, floats(0), floats(1))), floats(0.5)));
  };
  const shape = [
    ...to(scales),
    ...stored(or(or(size(0), shiftedLeft(size(1), number(11))), shiftedLeft(size(2), number(22))), 2),
    ...to(quats),
    // the largest of the four, its size and its number
    ...column(0), ...set(x), ...integers(0), ...set(byte),
    ...[1, 2, 3].flatMap((i) => [
      ...above(absolute(column(i)), absolute(get(x))), ...set(a),
      ...select(column(i), get(x), get(a)), ...set(x),
      ...select(integers(i), get(byte), get(a)), ...set(byte),
    ]),
    ...sameInteger(and(get(x), integers(0x7fffffff)), integers(0)), ...set(lost),
    ...select(floats(-turn), floats(turn), below(get(x), floats(0))), ...set(grow),
    ...get(byte), ...set(a),
    ...[0, 1, 2].flatMap((i) => [
      ...times(get(grow), select(column(i + 1), column(i), notAboveInteger(get(byte), integers(i)))), ...set(x),
      ...or(
        shiftedLeft(get(a), number(10)),
        and(whole(plus(get(x), floats(1024.5))), integers(1023)),
      ), ...set(a),
    ]),
    ...stored(get(a), 3),
  ];
  const code = [
    ...loop([...shape, ...color, ...lobe, ...advance(row, 16)], [...get(row), ...number(rowBytes), BELOW]),
    0x0b,
  ];
  return [2, 7, I32, 11, V128, ...code];
}

/** @type {((memory: WebAssembly.Memory) => Record<string, Function> | null) | undefined} */
let make;
/** @type {WeakMap<WebAssembly.Memory, Function | null>} */
const known = new WeakMap();

/**
 * The function in a memory; null where there is no such thing, or it is forbidden.
 *
 * @param {WebAssembly.Memory} memory
 * @param {import("./pack.js").Constants} constants
 */
export function packerIn(memory, constants) {
  make ??= assembled({
    pack: { parameters: [I32, I32, I32, I32, I32, I32, I32, F32, F32], body: packBody(constants) },
  });
  let found = known.get(memory);
  if (found === undefined) known.set(memory, (found = make(memory)?.pack ?? null));
  return found;
}
