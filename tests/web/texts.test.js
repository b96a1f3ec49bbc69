import assert from "node:assert/strict";
import { test } from "node:test";

import * as all from "../../viewer/src/viewer/texts.js";

const { LANGUAGES, en } = all;
const others = LANGUAGES.filter((language) => language !== "en");
const holes = (text) => text.split("{}").length - 1;

test("each language has every text, with as many values", () => {
  assert.deepEqual(Object.keys(all).sort(), ["LANGUAGES", ...LANGUAGES].sort());
  for (const language of others) {
    const texts = all[language];
    assert.deepEqual(Object.keys(texts), Object.keys(en), language);
    for (const [name, text] of Object.entries(texts)) {
      assert.ok(text.trim(), `${language}: ${name}`);
      assert.equal(holes(text), holes(en[name]), `${language}: ${name}`);
    }
  }
});

test("no text was left in English", () => {
  for (const language of others) {
    const same = Object.entries(all[language]).filter(([name, text]) => text === en[name]);
    assert.deepEqual(same, [], language);
  }
});
