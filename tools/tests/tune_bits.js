// node tune_bits.js FOLDER < cases: runs each case by the page's own engine, out of its folder, and prints what it came to.
"use strict";
const fs = require("fs");
const path = require("path");

const whole = new module.constructor("engine");
whole._compile(["engine.js", "em.js", "equations.js"].map((name) => fs.readFileSync(path.join(process.argv[2], name), "utf8")).join("\n"), "engine.js");
const engine = whole.exports;
const packed = (values) => Buffer.from(values.buffer, values.byteOffset, values.byteLength).toString("base64");

async function one(core, { content, asked, names, free, code, late, em, sweep }) {
  if (code) return engine.codeOf(content, asked);
  const made = await engine.made(core, content);
  if (late) made.setLate(late.cells, late.rows);
  if (sweep) return sweep.map((asked) => { try { return made.run(asked).total; } catch (problem) { return refused(problem).refused; } });
  if (em === "degrees") return engine.degrees(made);
  if (em === "step") {
    const at = asked.theta.map((_, k) => k), f = engine.logLikelihoodOf(made, asked, at, { calls: 0 });
    return engine.expectationStep(f, asked.theta.map(Math.log), engine.degrees(made), made.model.noises.map((one) => one.power)).map(Math.exp);
  }
  if (em) return engine.expectation(made, asked, free);
  if (free) return engine.fit(made, asked, free);
  const { total } = made.run(asked), told = names.map((name) => [name, packed(made.result(name))]);
  return { total, apart: made.compared ? made.compared() : null, ...Object.fromEntries(told) };
}

/* What is refused is what it came to. */
function refused(problem) {
  if (problem.constructor.name !== "Refusal") throw problem;
  return { refused: problem.message };
}

async function main() {
  const { core, cases } = JSON.parse(fs.readFileSync(0)), told = [];
  for (const given of cases) told.push(await one(Buffer.from(core, "base64"), given).catch(refused));
  process.stdout.write(JSON.stringify(told));
}
main();
