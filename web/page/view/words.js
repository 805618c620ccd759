// Numbers and quantities as words.

const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"]];

/** A quantity with a prefix that keeps it short: 0.0000123 s is 12.3 µs. */
function quantity(value, unit, digits = 3) {
  if (value === 0) return `0 ${unit}`;
  if (!Number.isFinite(value)) return `– ${unit}`;
  const size = Math.abs(value) * (1 + 1e-12);
  const [factor, prefix] = PREFIXES.find(([least]) => size >= least) ?? PREFIXES.at(-1);
  return `${rounded(value / factor, digits)} ${prefix}${unit}`;
}

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
