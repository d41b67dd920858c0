"use strict";
// uPlot with pixels to the point that the page chooses: it asks the screen for them, which knows nothing of paper.
const uPlot = (() => {
  let devicePixelRatio = window.devicePixelRatio || 1, changed = () => {};
  const matchMedia = () => ({ addEventListener: (_, heard) => { changed = heard; }, removeEventListener: () => {} });
  /* library */
  uPlot.resolution = (ratio) => { devicePixelRatio = ratio; changed(); };
  return uPlot;
})();
