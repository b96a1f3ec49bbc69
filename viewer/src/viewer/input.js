/** Moves the pose by pointers, wheel and keys. */

/** @typedef {import("./pose.js").Pose} Pose */
/**
 * @typedef {object} Target callbacks of the input
 * @property {() => Pose} pose
 * @property {() => import("./viewer.js").Mode} mode
 * @property {() => void} held a pointer went down
 * @property {() => void} changed the pose has changed
 * @property {(x: number, y: number) => void} focus look at the point under a pixel, CSS pixels
 */

const TURN = 0.006; // radians per pixel
const WHEEL = 0.0012; // share of the distance per wheel unit
const PINCH = 8; // wheel units per trackpad unit
const SPEED = 0.9; // distances to the target per second, flying with keys
const SHAKE = 6; // pixels that a finger may move in a tap
const TAP = 0.03; // seconds that a short press counts for
const FLYING = new Map([
  ["KeyW", [0, 0, 1]],
  ["KeyS", [0, 0, -1]],
  ["KeyA", [-1, 0, 0]],
  ["KeyD", [1, 0, 0]],
  ["KeyQ", [0, 1, 0]],
  ["KeyE", [0, -1, 0]],
]);
const TURNING = new Map([
  ["ArrowLeft", [-1, 0]],
  ["ArrowRight", [1, 0]],
  ["ArrowUp", [0, -1]],
  ["ArrowDown", [0, 1]],
]);

/** Listens to the events of an element that can have the focus. */
export class Input {
  #element;
  #target;
  #stop = new AbortController();
  /** Position of each pointer. @type {Map<number, {x: number, y: number}>} */
  #pointers = new Map();
  /** @type {Set<string>} */
  #keys = new Set();
  #shift = false;
  /** How far a stick is pushed to the right and forwards, -1 to 1. */
  stride = [0, 0];
  #pressed = { x: 0, y: 0, time: 0 }; // previous tap, to detect a double tap

  /**
   * @param {HTMLElement} element
   * @param {Target} target
   */
  constructor(element, target) {
    this.#element = element;
    this.#target = target;
    const listen = (/** @type {string} */ kind, /** @type {(event: any) => void} */ act) =>
      element.addEventListener(kind, act, { signal: this.#stop.signal, passive: false });
    listen("pointerdown", (event) => this.#down(event));
    listen("pointermove", (event) => this.#move(event));
    listen("pointerup", (event) => this.#up(event));
    listen("pointercancel", (event) => this.#up(event));
    listen("wheel", (event) => this.#wheel(event));
    listen("contextmenu", (event) => event.preventDefault());
    listen("keydown", (event) => this.#key(event, true));
    listen("keyup", (event) => this.#key(event, false));
    listen("blur", () => this.#keys.clear());
  }

  /** True if movement keys are down, or a stick is pushed. */
  get busy() {
    return this.#keys.size > 0 || this.stride.some(Boolean);
  }

  /** True while a pointer or a movement key is down. */
  get held() {
    return this.busy || this.#pointers.size > 0;
  }

  /** Move by the keys that are down. @param {number} seconds since the last call */
  advance(seconds) {
    if (!this.busy) return;
    const pose = this.#target.pose();
    const step = SPEED * pose.reach * seconds * (this.#shift ? 4 : 1);
    for (const key of this.#keys) {
      const way = FLYING.get(key);
      if (way) this.#go(way[0] * step, way[1] * step, way[2] * step);
      const turn = TURNING.get(key);
      if (turn) this.#turn(turn[0] * 1.5 * seconds, turn[1] * 1.5 * seconds);
    }
    const [right, forward] = this.stride;
    if (right || forward) this.#go(right * step, 0, forward * step);
    this.#target.changed();
  }

  /** Move along the picture's axes, or along the floor. @param {number} right @param {number} down @param {number} forward */
  #go(right, down, forward) {
    const pose = this.#target.pose();
    if (this.#target.mode() === "walk") pose.walk(right, forward);
    else pose.move(right, down, forward);
  }

  destroy() {
    this.#stop.abort();
  }

  /** @param {number} across @param {number} down radians */
  #turn(across, down) {
    const pose = this.#target.pose();
    if (this.#target.mode() === "orbit") pose.orbit(across, down);
    else pose.look(across, down);
  }

  /** @param {PointerEvent} event */
  #down(event) {
    this.#element.focus({ preventScroll: true });
    this.#element.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    const { x, y, time } = this.#pressed;
    const close = Math.hypot(event.offsetX - x, event.offsetY - y) < 20;
    const alone = this.#pointers.size === 1 && event.button === 0;
    if (alone && close && event.timeStamp - time < 350) this.#target.focus(event.offsetX, event.offsetY);
    this.#pressed = { x: event.offsetX, y: event.offsetY, time: alone ? event.timeStamp : -Infinity };
    this.#target.held();
    event.preventDefault();
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const last = this.#pointers.get(event.pointerId);
    if (last === undefined) return;
    const now = { x: event.offsetX, y: event.offsetY };
    if (Math.hypot(now.x - this.#pressed.x, now.y - this.#pressed.y) > SHAKE) this.#pressed.time = -Infinity; // no tap
    if (this.#pointers.size === 1) this.#drag(now.x - last.x, now.y - last.y, event);
    else if (this.#pointers.size === 2) this.#pinch(event.pointerId, now);
    this.#pointers.set(event.pointerId, now);
    this.#target.changed();
  }

  /** @param {PointerEvent} event */
  #up(event) {
    this.#pointers.delete(event.pointerId);
  }

  /** @param {number} dx @param {number} dy @param {PointerEvent} event */
  #drag(dx, dy, event) {
    const panning = event.buttons & 6 || event.shiftKey || event.ctrlKey;
    if (panning) this.#pan(dx, dy);
    else this.#turn(dx * TURN, dy * TURN);
  }

  /** Two fingers: their distance zooms, their middle pans. @param {number} id @param {{x: number, y: number}} now */
  #pinch(id, now) {
    const last = this.#pointers.get(id);
    const other = [...this.#pointers].find(([key]) => key !== id)?.[1];
    if (last === undefined || other === undefined) return;
    const before = Math.hypot(last.x - other.x, last.y - other.y);
    const after = Math.hypot(now.x - other.x, now.y - other.y);
    if (this.#target.mode() !== "orbit") this.#go(0, 0, 2 * (after - before) * this.#unit);
    else if (before > 0 && after > 0) this.#target.pose().dolly(before / after);
    this.#pan((now.x - last.x) / 2, (now.y - last.y) / 2);
  }

  /** @param {number} dx @param {number} dy pixels */
  #pan(dx, dy) {
    this.#go(-dx * this.#unit, -dy * this.#unit, 0);
  }

  /** World units per pixel at the target. */
  get #unit() {
    const { target, eye } = this.#target.pose();
    return Math.hypot(...target.map((value, k) => value - eye[k])) / Math.max(this.#element.clientHeight, 1);
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    if (this.#element.classList.contains("polite") && !event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
    // browsers report a pinch on a trackpad as a wheel with Ctrl, in small steps
    const amount = event.deltaY * lines * (event.ctrlKey ? PINCH : 1) * WHEEL;
    const pose = this.#target.pose();
    if (this.#target.mode() === "orbit") pose.dolly(Math.exp(amount));
    else this.#go(0, 0, -amount * pose.reach);
    this.#target.changed();
  }

  /** @param {KeyboardEvent} event @param {boolean} down */
  #key(event, down) {
    const { code } = event;
    this.#shift = event.shiftKey;
    // with Cmd held, browsers send no keyup of other keys
    if (!down && code.startsWith("Meta")) this.#keys.clear();
    if (down && (event.ctrlKey || event.metaKey || event.altKey)) return;
    if (!FLYING.has(code) && !TURNING.has(code)) return;
    const fresh = down && !this.#keys.has(code);
    if (down) this.#keys.add(code);
    else this.#keys.delete(code);
    if (fresh) this.advance(TAP); // the key may be released before the next frame
    this.#target.changed();
    event.preventDefault();
  }
}
