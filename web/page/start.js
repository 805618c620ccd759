// Unpacks the engine and starts the page.

/** What lies in an element of the page, unpacked. */
function unpacked(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
}

/** The page, once the engine is unpacked. */
const ready = (async () => {
  fillTexts();
  const engine = await Engine.load(await unpacked("engine").arrayBuffer());
  document.getElementById("engine").remove();
  return (window.cradle = new App(engine));
})().catch((problem) => {
  document.getElementById("status").textContent = `${say("problem")}: ${problem.message}`;
  throw problem;
});
