"use strict";
/* Answers one message after the other, in a worker or in the page itself. */

let engine = null, given = null, smoothedState = -1;

const ANSWERS = {
  async begin({ wasm, content }) {
    engine = await made(wasm, content);
    given = engine.measurements().slice();
    return {};
  },
  edit({ cells, values }) {
    const z = engine.measurements();
    z.set(given);
    cells.forEach((cell, k) => { z[cell] = values[k]; });
    return {};
  },
  /* All but what a smoother has to say; the fit's and the smoother's worker has the rest. */
  run({ asked, shows }) {
    const told = engine.run({ ...asked, smooth: false });
    const pictured = pictures(engine, shows, asked.lag);
    return { ...told, pictures: pictured, ...judged(shows), headroom: asked.arithmetic === "q31" ? headroom(engine) : null };
  },
  look({ asked, shows }) {
    return { pictures: pictures(engine, shows, asked.lag), ...judged(shows) };
  },
  smooth({ asked, shows }) {
    const only = shows.state < engine.model.n ? shows.state : -1; // a measurement is of all of them
    engine.run({ ...asked, lag: 0, ahead: 0, smooth: true, alone: true, only });
    smoothedState = only;
    return { pictures: smoothed(engine, shows) };
  },
  look_smooth({ asked, shows }) {
    return smoothedState === -1 || smoothedState === shows.state ? { pictures: smoothed(engine, shows) } : ANSWERS.smooth({ asked, shows });
  },
  fit({ asked, free }, tell) { return fit(engine, asked, free, tell); },
  distance({ asked }) { return { far: Object.fromEntries((engine.canFix ? ["f32", "q31"] : ["f32"]).map((one) => [one, tried(() => distance(engine, asked, one))])) }; },
};

function judged(shows) {
  return { consistency: consistency(engine), correlation: autocorrelation(engine, shows.measurement) };
}

function tried(what) {
  try { return what(); } catch (problem) { return problem.message; }
}

async function answer(message, tell) {
  const begun = performance.now();
  try {
    const made = await ANSWERS[message.kind](message, tell);
    return { id: message.id, ...made, took: performance.now() - begun };
  } catch (problem) {
    return { id: message.id, refused: problem.message };
  }
}

if (typeof document === "undefined" && typeof self !== "undefined") {
  let last = Promise.resolve(); // one after the other
  self.onmessage = ({ data }) => {
    last = last.then(async () => self.postMessage(await answer(data, (told) => self.postMessage({ id: data.id, told }))));
  };
}
