// Elements of the page.

import { inflated } from "#view/common.js";

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

/** What lies in an element of the page, unpacked. */
export function unpacked(id) { return inflated(document.getElementById(id).textContent, "gzip"); }
