// Unpacks the engine and starts the page.

/** The page, once the engine is unpacked. */
const ready = (async () => {
  fillTexts();
  const bytes = Uint8Array.from(atob(document.getElementById("engine").textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const engine = await Engine.load(await new Response(stream).arrayBuffer());
  document.getElementById("engine").remove();
  return (window.cradle = new App(engine));
})().catch((problem) => {
  document.getElementById("status").textContent = `${say("problem")}: ${problem.message}`;
  throw problem;
});
