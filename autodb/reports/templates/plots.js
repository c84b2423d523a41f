// Draws the plots of a page, which are in it as data, and has them fit a sheet of paper.
(() => {
  const plots = () => document.querySelectorAll(".js-plotly-plot");
  const grids = () => document.querySelectorAll(".grid");
  const drawings = () => document.querySelectorAll(".plot .main-svg");
  const resize = () => plots().forEach((plot) => Plotly.Plots.resize(plot));
  const undrawn = document.querySelectorAll(".plotly-graph-div > script");
  if (!window.Plotly) {
    undrawn.forEach((data) => {
      data.parentElement.textContent = document.querySelector("[data-missing]").dataset.missing;
    });
    return;
  }
  undrawn.forEach((data) => {
    const { figure, config } = JSON.parse(data.textContent);
    const place = data.parentElement;
    data.remove();
    Plotly.newPlot(place, figure.data, figure.layout, config);
  });
  // On a touch screen a finger on a plot scrolls the page; the buttons of the plot zoom.
  if (matchMedia("(pointer: coarse)").matches) {
    plots().forEach((plot) => Plotly.relayout(plot, { dragmode: false }));
  }
  // On paper everything is open, and a plot is scaled to the sheet.
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = [...document.querySelectorAll("details:not([open])")];
    closed.forEach((part) => { part.open = true; });
    grids().forEach((grid) => {
      const columns = getComputedStyle(grid).gridTemplateColumns.split(" ");
      const count = columns.filter((width) => parseFloat(width) > 0).length;
      grid.style.gridTemplateColumns = `repeat(${count}, minmax(0, 1fr))`;
    });
    drawings().forEach((drawing) => {
      const size = ["width", "height"].map((side) => parseFloat(drawing.getAttribute(side)));
      drawing.setAttribute("viewBox", `0 0 ${size.join(" ")}`);
    });
  });
  addEventListener("afterprint", () => {
    closed.forEach((part) => { part.open = false; });
    grids().forEach((grid) => { grid.style.gridTemplateColumns = ""; });
    drawings().forEach((drawing) => drawing.removeAttribute("viewBox"));
    resize();
  });
  document.querySelectorAll("details").forEach((part) => part.addEventListener("toggle", resize));
})();
