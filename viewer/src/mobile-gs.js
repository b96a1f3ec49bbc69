/** Entry point of `mobile-gs.js`: in a page it defines `<mobile-gs>`, in a worker it loads scenes. It needs no other file. */

import "./element.js";
import { startWorker } from "./load/worker.js";
import { startPage } from "./page.js";

if (!globalThis.document) startWorker();
else if (document.querySelector("mobile-gs[page]")) startPage();
