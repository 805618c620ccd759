// Keeps the page where there is no network: what the server answered last is the answer then.

const FILES = ["./", "cradle.webmanifest", "icon.svg"], kept = caches.open("cradle");

addEventListener("install", (event) => event.waitUntil(kept.then((cache) => cache.addAll(FILES))));
addEventListener("fetch", (event) => event.respondWith(answer(event.request)));

async function answer(request) {
  const cache = await kept;
  await cache.add(request).catch(() => {}); // asks the server
  return await cache.match(request, { ignoreSearch: true }) ?? fetch(request);
}
