/** A stick for walking on touch screens: how far it is pushed, to the right and forwards. */

const REACH = 44; // CSS pixels from the middle to the end

/**
 * Make a part of the element a stick.
 *
 * @param {HTMLElement} part its first child is the knob
 * @param {(right: number, forward: number) => void} push each -1 to 1; both 0 when it is let go
 */
export function makeJoystick(part, push) {
  const knob = /** @type {HTMLElement} */ (part.firstElementChild);
  /** @type {number | null} */
  let pointer = null;
  const show = (/** @type {number} */ x, /** @type {number} */ y) => {
    knob.style.transform = `translate(${x}px, ${y}px)`;
    push(x / REACH, -y / REACH);
  };
  part.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    pointer = event.pointerId;
    part.setPointerCapture(pointer);
    move(event);
  });
  const move = (/** @type {PointerEvent} */ event) => {
    if (event.pointerId !== pointer) return;
    const { left, top, width, height } = part.getBoundingClientRect();
    const [x, y] = [event.clientX - left - width / 2, event.clientY - top - height / 2];
    const share = Math.min(1, REACH / (Math.hypot(x, y) || 1));
    show(x * share, y * share);
  };
  const release = (/** @type {PointerEvent} */ event) => {
    if (event.pointerId !== pointer) return;
    pointer = null;
    show(0, 0);
  };
  part.addEventListener("pointermove", move);
  part.addEventListener("pointerup", release);
  part.addEventListener("pointercancel", release);
}
