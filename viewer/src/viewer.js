/** Entry point of `viewer.js`: in a page it starts the viewer, in a worker it loads scenes. */

import { startWorker } from "./load/worker.js";
import { startPage } from "./page.js";

if (globalThis.document) startPage();
else startWorker();
