"use strict";
/* Answers one message after the other, in a worker or, where there is none, in the page itself. */

function desk() {
  let engine = null, given = null, smoothedState = -1;

  const judged = (shows) => ({ consistency: consistency(engine), correlation: autocorrelation(engine, shows.measurement) });
  const far = (asked, arithmetic) => { try { return distance(engine, asked, arithmetic); } catch (problem) { return problem.message; } };

  function smooth({ asked, shows }) {
    const only = shows.state < engine.model.n ? shows.state : -1; // a measurement is of all of them
    engine.run({ ...asked, lag: 0, ahead: 0, smooth: true, alone: true, only });
    smoothedState = only;
    return { pictures: smoothed(engine, shows) };
  }

  const answers = {
    async begin({ wasm, content }) {
      engine = await made(wasm, content);
      given = engine.measurements().slice();
      return {};
    },
    edit({ cells, values, late, rows }) {
      const z = engine.measurements();
      z.set(given);
      cells.forEach((cell, k) => { z[cell] = values[k]; });
      engine.setLate?.(late, rows);
      return {};
    },
    /* All but what a smoother has to say */
    run({ asked, shows }) {
      const told = engine.run({ ...asked, smooth: false });
      return { ...told, pictures: pictures(engine, shows, asked.lag), ...judged(shows), headroom: asked.arithmetic === "q31" ? headroom(engine) : null,
               apart: engine.compared ? engine.compared() : null };
    },
    look: ({ asked, shows }) => ({ pictures: pictures(engine, shows, asked.lag), ...judged(shows) }),
    smooth,
    look_smooth: ({ asked, shows }) => (smoothedState === -1 || smoothedState === shows.state ? { pictures: smoothed(engine, shows) } : smooth({ asked, shows })),
    fit: ({ asked, free }, tell) => fit(engine, asked, free, tell),
    em: ({ asked, free }, tell) => expectation(engine, asked, free, tell),
    distance: ({ asked }) => ({ far: Object.fromEntries((engine.canFix ? ["f32", "q31"] : ["f32"]).map((one) => [one, far(asked, one)])) }),
  };

  return async function answer(message, tell) {
    try {
      return { id: message.id, ...(await answers[message.kind](message, tell)) };
    } catch (problem) {
      return { id: message.id, refused: problem.message };
    }
  };
}

if (typeof document === "undefined" && typeof self !== "undefined") {
  const answer = desk();
  let last = Promise.resolve(); // one after the other
  self.onmessage = ({ data }) => {
    last = last.then(async () => self.postMessage(await answer(data, (told) => self.postMessage({ id: data.id, told }))));
  };
}
