// The engine of a finished page without a browser: node web/run.mjs PAGE < request > answer, both JSON.
//
// request: {recipe: {balls, start}, times: [s]}; answer: {rows: what `look` shows at each time, pulses, seconds}.

import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";
import { gunzipSync } from "node:zlib";

const page = readFileSync(process.argv[2], "utf8");
const [, packed] = page.match(/<script type="text\/plain" id="engine">([^<]*)</);
// The page's own script, of which only the classes of the engine are used here.
const [, script] = page.match(/<script>\s*"use strict";([\s\S]*)<\/script>/);
const [classes] = script.split("// A set-up:");
const { Engine } = runInThisContext(`(() => { ${classes}; return { Engine }; })()`);

const { recipe, times } = JSON.parse(readFileSync(0, "utf8"));
const engine = await Engine.load(gunzipSync(Buffer.from(packed, "base64")));
const begun = performance.now(), run = engine.start(recipe), pulses = [];
const rows = times.map((time) => {
  run.advance(time);
  pulses.push(...run.takePulses());
  return Array.from(run.look().numbers);
});
console.log(JSON.stringify({ rows, pulses, seconds: (performance.now() - begun) / 1000, memory: engine.memory }));
