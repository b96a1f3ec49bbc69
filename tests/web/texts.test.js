import assert from "node:assert/strict";
import { test } from "node:test";

import { visible } from "../../viewer/src/viewer/localize.js";
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

test("characters that turn or hide others are shown as numbers", () => {
  const cases = {
    "photo\u202egpj.exe": "photo\\u202egpj.exe",
    "\u2066a\u2069\x1b[2J\x85\0": "\\u2066a\\u2069\\u001b[2J\\u0085\\u0000",
    "two\nlines\tעברית\u200f 👩‍🌾 café": "two\nlines\tעברית\u200f 👩‍🌾 café",
  };
  for (const [text, shown] of Object.entries(cases)) assert.equal(visible(text), shown);
});
