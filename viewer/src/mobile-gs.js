/** Entry point of `mobile-gs.js`: the element, and a whole page if it has the attribute `page`. It needs no other file. */

import { startPage } from "./page.js";

if (document.querySelector("mobile-gs[page]")) startPage();
