/** Entry point of `mobile-gs.js`: in a page it defines `<mobile-gs>`, in a worker it loads scenes. */

import "./element.js";
import { startWorker } from "./load/worker.js";

if (!globalThis.document) startWorker();
