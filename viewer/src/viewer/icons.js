/** Icons of 24 by 24, drawn as lines. */

/** @param {number} x @param {number} y @param {number} radius */
const circle = (x, y, radius) =>
  `M${x - radius} ${y}a${radius} ${radius} 0 1 0 ${2 * radius} 0a${radius} ${radius} 0 1 0-${2 * radius} 0`;

const PATHS = {
  reset: "M4 11.5l8-7 8 7M6.5 9.5V19.5h11V9.5",
  share: "M12 15V3.5M8 7.5l4-4 4 4M7 11.5H5v9h14v-9h-2",
  settings: `M4 8h7.5M16.5 8H20M4 16h3.5M12.5 16H20${circle(14, 8, 2.5)}${circle(10, 16, 2.5)}`,
  full: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",
  window: "M9 4v5H4M20 9h-5V4M15 20v-5h5M4 15h5v5",
  help: `${circle(12, 12, 9)}M9.5 9.5a2.5 2.5 0 1 1 3.7 2.2c-.9.5-1.2 1-1.2 2M12 17v.01`,
  close: "M6.5 6.5l11 11M17.5 6.5l-11 11",
  drag: `M2.5 12.5c0 3.5 4 6 9.5 6s9.5-2.5 9.5-6M.5 14.5l2-2.5 2.5 2M19 14l2.5-2 2 2.5${circle(12, 8, 4)}`,
  vr: "M3.5 7.5h17v9.5h-5.5l-3-3.5-3 3.5H3.5zM8 11.5v.01M16 11.5v.01",
  ar: "M12 3.5l7.5 4.3v8.4L12 20.5l-7.5-4.3V7.8zM4.5 7.8l7.5 4.2 7.5-4.2M12 12v8.5",
  wake: "M8 5l11 7-11 7z",
  alert: "M12 4.5L3 19.5h18zM12 10.5v4M12 17v.01",
};

/** @param {keyof typeof PATHS} name @returns {string} HTML */
export const icon = (name) => `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${PATHS[name]}"/></svg>`;
