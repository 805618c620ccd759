// Elements of the page.

/** A new element with these properties, at the end of another one. */
export function element(parent, name, properties = {}) {
  return parent.appendChild(Object.assign(document.createElement(name), properties));
}

/** Sets ARIA attributes of an element; Firefox has properties such as `ariaLabel` only since version 119. */
export function aria(item, words) {
  for (const [kind, word] of Object.entries(words)) {
    if (item.getAttribute(`aria-${kind}`) !== String(word)) item.setAttribute(`aria-${kind}`, word);
  }
  return item;
}

/** Decompresses base64 data of this format. */
export function inflated(text, format) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format)));
}

/** The unpacked content of an element of the page. */
export function unpacked(id) { return inflated(document.getElementById(id).textContent, "gzip"); }
