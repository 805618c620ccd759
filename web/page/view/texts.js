// What the page says: the tables of web/page/texts, one for each language.

let tables, language, table, plurals, roughly; // until `learn` has been called, nothing is said

/** Takes the tables by language code, and chooses the first available of `languages`, otherwise English. */
export function learn(all, languages) {
  tables = all;
  speak(languages.map((language) => language.split("-")[0]).find((code) => code in tables) ?? "en");
}

/** Switches to the language with this code. */
export function speak(code) {
  [language, table] = [code, tables[code]];
  plurals = new Intl.PluralRules(code);
  roughly = new Intl.NumberFormat(code, { maximumSignificantDigits: 2 });
  fillTexts();
}

/** The languages that there are, {code: name}, and the code of the one that is spoken. */
export function languages() {
  return [Object.fromEntries(Object.entries(tables).map(([code, { language: name }]) => [code, name])), language];
}

/** The entry of this name, such as `presets.desk`: a text, or a list or table of texts. */
export function textsOf(name) { return name.split(".").reduce((part, key) => part?.[key], table); }

/** The text with this name, its {places} filled with these values. Where it has forms for numbers, `count` chooses: one
 *  for this number or for those like it. */
export function say(name, values = {}) {
  const found = textsOf(name), { count } = values;
  const text = found.other ? found[count] ?? found[plurals.select(count)] ?? found.other : found;
  return text.replace(/{(\w+)}/g, (_, place) => values[place]);
}

/** Fills in what elements of the page ask for: data-text their text, data-label their accessible name. */
function fillTexts() {
  document.title = say("title");
  document.documentElement.lang = language;
  for (const element of document.querySelectorAll("[data-text]")) element.textContent = say(element.dataset.text);
  for (const element of document.querySelectorAll("[data-label]"))
    element.setAttribute("aria-label", say(element.dataset.label));
}

/** A small number as a word, so that it does not read as a part of another one. */
export function inWords(count) { return textsOf("numbers")[count] ?? String(count); }

/** A contact by its balls; both are counted from 1. */
export const contactName = (contact) => `${contact + 1}–${contact + 2}`;

/** A text whose lines do not break between a number and what belongs to it: its unit, or another number. */
export function unbroken(text) {
  return text.replace(/(?<=\d) (?=[GMkmµnpf]?[msNJ]\b|kg\b|[%\d])/g, "\u00a0");
}

/** How fast time runs, at this rate. */
export function paceText(rate) {
  return rate > 0.87 ? say("realTime") : say("slower", { times: roughly.format(1 / rate) });
}

export const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

/** With this many significant digits; what is tiny with a power of ten: 3.1 × 10⁻¹⁶. */
export function rounded(value, digits = 3) {
  const short = Number(value.toPrecision(digits)), plain = Math.abs(short) >= 1e-4 || short === 0;
  const [mantissa, exponent = ""] = (plain ? String(short) : short.toExponential()).split("e");
  const raised = [...exponent].map((letter) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[letter] ?? "⁻").join("");
  return (exponent ? `${mantissa} × 10${raised}` : mantissa).replace("-", "−");
}
