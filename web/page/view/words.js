// Numbers as words; quantities: see withPrefix in python/newtons_cradle/look/common.js.

const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";

/** With this many significant digits, without a power of ten where that can be avoided. */
function rounded(value, digits = 3) {
  const short = Number(value.toPrecision(digits));
  return String(Math.abs(short) >= 1e-4 || short === 0 ? short : value.toExponential(Math.max(0, digits - 1))).replace("-", "−");
}

/** A tiny number as it is said of residuals: 3.1e-16 becomes 3.1 × 10⁻¹⁶. */
function power(value, digits = 2) {
  if (value === 0) return "0";
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const raised = [...String(Number(exponent))].map((letter) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[letter] ?? "⁻").join("");
  return `${mantissa.replace("-", "−")} × 10${raised}`;
}
