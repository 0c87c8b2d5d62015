// Puts a plot that can be zoomed in the place of each drawing that brings its numbers; without scripts the drawing stays.
'use strict';
(() => {
  // Two fingers hold the values that they stand on.
  const pinch = plot => {
    let held = null;
    const places = touches => [...touches].map(touch => touch.clientX - plot.over.getBoundingClientRect().left).sort((a, b) => a - b);
    plot.over.addEventListener('touchstart', event => {
      held = event.touches.length === 2 ? places(event.touches).map(place => plot.posToVal(place, 'x')) : null;
    });
    plot.over.addEventListener('touchmove', event => {
      if (!held || event.touches.length !== 2) return;
      event.preventDefault();
      const [left, right] = places(event.touches);
      if (right - left < 10) return;
      const per = (held[1] - held[0]) / (right - left);
      const min = held[0] - left * per;
      plot.setScale('x', { min, max: min + per * plot.over.clientWidth });
    }, { passive: false });
  };
  for (const figure of document.querySelectorAll('figure')) {
    const given = figure.querySelector('script');
    const drawing = figure.querySelector('svg');
    if (!given || !drawing) continue;
    const { x_label, y_label, x, curves, bands } = JSON.parse(given.textContent);
    const place = document.createElement('div');
    for (const name of ['role', 'aria-label']) place.setAttribute(name, drawing.getAttribute(name));
    const size = () => {
      const width = figure.clientWidth - 12;
      return { width, height: Math.round(Math.max(240, Math.min(340, 0.6 * width))) };
    };
    const curve = one => ({ label: one.name, stroke: one.colour, width: one.width, points: { show: false }, value: (_, y) => y == null ? '–' : y.toFixed(2) });
    drawing.replaceWith(place);
    const plot = figure.plot = new uPlot({
      ...size(),
      scales: { x: { time: false } },
      axes: [{ label: x_label }, { label: y_label }],
      series: [{ label: x_label, value: (_, at) => at == null ? '–' : at.toFixed(2) }, ...curves.map(curve)],
      bands: bands.map(band => ({ series: band, fill: curves[band[0] - 1].fill })),
    }, [x, ...curves.map(one => one.y)], place);
    pinch(plot);
    figure.querySelector('figcaption').append(' Drag over a stretch to zoom in, or pinch; click twice to see all of it.');
    addEventListener('resize', () => plot.setSize(size()));
  }
})();
