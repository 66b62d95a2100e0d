// node tune_bits.js ENGINE CORE.wasm < cases: runs each case by the page's own engine, and prints what it came to.
"use strict";
const fs = require("fs");
const engine = require(process.argv[2]);

const packed = (values) => Buffer.from(values.buffer, values.byteOffset, values.byteLength).toString("base64");

async function main() {
  const core = fs.readFileSync(process.argv[3]), told = [];
  for (const { content, asked, names, free } of JSON.parse(fs.readFileSync(0))) {
    const made = await engine.made(core, content);
    if (free) { told.push(engine.fit(made, asked, free)); continue; }
    const { total } = made.run(asked);
    told.push({ total, ...Object.fromEntries(names.map((name) => [name, packed(made.result(name))])) });
  }
  process.stdout.write(JSON.stringify(told));
}
main();
