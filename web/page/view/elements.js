// Elements of the page.

/** A new element with these properties, at the end of another one. */
export function element(parent, name, properties = {}) {
  return parent.appendChild(Object.assign(document.createElement(name), properties));
}

/** Tells assistive technology more of an element. Firefox has properties such as `ariaLabel` since version 119 only. */
export function aria(item, words) {
  for (const [kind, word] of Object.entries(words)) {
    if (item.getAttribute(`aria-${kind}`) !== String(word)) item.setAttribute(`aria-${kind}`, word);
  }
  return item;
}

/** What was compressed in this format and written in base64. */
export function inflated(text, format) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format)));
}

/** What lies in an element of the page, unpacked. */
export function unpacked(id) { return inflated(document.getElementById(id).textContent, "gzip"); }
