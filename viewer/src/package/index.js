/**
 * Entry point `mobilegs`: the decoder, and where workers start from.
 *
 *     import { decodeMgs } from "mobilegs";
 *
 *     const { count, means, sh } = await decodeMgs(await fetch("scene.mgs"));
 */

export { SceneError } from "../mgs/error.js";
export { decodeMgs } from "./decode.js";
export { setWorker, workerScript } from "./hosted_worker.js";

/** @typedef {import("./decode.js").DecodeOptions} DecodeOptions */
/** @typedef {import("./decode.js").MgsCamera} MgsCamera */
/** @typedef {import("./decode.js").MgsFootprint} MgsFootprint */
/** @typedef {import("./decode.js").MgsProgress} MgsProgress */
/** @typedef {import("./decode.js").MgsScene} MgsScene */
/** @typedef {import("./decode.js").MgsSource} MgsSource */
/** @typedef {import("./decode.js").MgsWeighting} MgsWeighting */
