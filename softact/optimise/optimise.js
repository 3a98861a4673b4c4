/* A click on a point of a plot shows that trial's design. */

whenReady(async ({ packed }) => {
  const { first, of } = JSON.parse(new TextDecoder().decode(await inflated(packed)));
  for (const box of document.querySelectorAll("figure.chart .plot")) {
    box.on("plotly_click", (event) => {
      const number = event.points[0].customdata;
      if (number === undefined) return;  // the line of the best so far
      showRun(of[number]);
      byId("design").scrollIntoView();
    });
  }
  if (first !== null) await showRun(of[first]);
});
