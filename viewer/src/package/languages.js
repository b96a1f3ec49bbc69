/** The texts in other languages than English. */

import { unpacked } from "./unpacked.js";

/** @returns {Promise<Record<"de" | "es" | "ja" | "zh", import("../viewer/texts.js").Texts>>} */
export const languages = async () => JSON.parse(await unpacked(PACKED_TEXTS));
