/**
 * The graphics contexts of all elements in a page. Browsers give a page few of them, and take the oldest away
 * without asking when there are more: elements out of sight give theirs back before that.
 */

/**
 * @typedef {object} Holder an element
 * @property {boolean | null} inSight null: not known yet
 * @property {number} cost of its context: 1 of WebGPU, 2 of WebGL
 * @property {() => void} suspend gives its context back
 * @property {() => void} resume tries again to begin
 */

/** Costs at a time. Phones have eight contexts of WebGL, and calibration and comparisons need more; WebGPU has no such limit. */
const MOST = 8;

/** Those with a context; the one that was used last comes last. @type {Set<Holder>} */
const holders = new Set();
/** Those that wait for one. @type {Set<Holder>} */
const waiting = new Set();

const isHidden = (/** @type {Holder} */ { inSight }) => inSight === false;

/** Costs above MOST with one more context; not above 0 if it fits. @param {number} cost */
const excess = (cost) => [...holders].reduce((sum, one) => sum + one.cost, cost - MOST);

/**
 * Take a context.
 *
 * @param {Holder} holder
 * @param {boolean} asked whether a visitor asked for it: then an element in sight gives its own back
 * @returns {boolean} false: it waits until another gives its own back
 */
export function take(holder, asked) {
  holders.delete(holder);
  let most = excess(holder.cost);
  const able = [...holders].filter((one) => asked || isHidden(one)).sort((a, b) => +isHidden(b) - +isHidden(a));
  const enough = [];
  for (const other of able) {
    if (most <= 0) break;
    most -= other.cost;
    enough.push(other);
  }
  if (most > 0) {
    waiting.add(holder); // nobody is suspended in vain
    return false;
  }
  for (const other of enough) {
    holders.delete(other);
    waiting.add(other);
    other.suspend();
  }
  waiting.delete(holder);
  holders.add(holder);
  return true;
}

/** The element is gone. @param {Holder} holder */
export function giveBack(holder) {
  holders.delete(holder);
  waiting.delete(holder);
  wake();
}

/** The element came into sight or left it. @param {Holder} holder @param {boolean} inSight */
export function seen(holder, inSight) {
  holder.inSight = inSight;
  wake();
}

/** The visitor used the element. @param {Holder} holder */
export function used(holder) {
  if (holders.delete(holder)) holders.add(holder);
}

/** Let elements in sight try again, if there may be a context for them. */
function wake() {
  for (const one of [...waiting]) {
    if (one.inSight && (excess(one.cost) <= 0 || [...holders].some(isHidden))) one.resume();
  }
}
