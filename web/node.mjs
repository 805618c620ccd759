// A script with what a finished page is made of, without a browser: node web/node.mjs PAGE < SCRIPT
//
// SCRIPT is the body of an async function that knows the page's classes and functions, and `engine`; what it returns is
// printed as JSON.

import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";
import { gunzipSync } from "node:zlib";

const [, packed, classes] = readFileSync(process.argv[2], "utf8")
  .match(/id="engine">([^<]*)<.*?<script>(.*?)<\/script>/s);
const engine = "await Engine.load(packed)", script = readFileSync(0, "utf8");
const run = runInThisContext(`${classes}; (async (packed) => { const engine = ${engine}; ${script} })`);
const answer = await run(gunzipSync(Buffer.from(packed, "base64")));
if (answer !== undefined) console.log(JSON.stringify(answer));
