/** Entry point of `viewer.js`: the page of `mobilegs view`, whose element is a whole page. */

import { startPage } from "./page.js";

startPage();
