// Colours of night and day that are drawn with; those of the page are in style.css.

export const NIGHT = {
  dark: true, back: "#0f141a", ink: "#eaf0f6", accent: "#ffb54a", focus: "#7cc4ff", grid: "rgba(255,255,255,.14)",
  spike: "#ffb54a",
  string: "rgba(214,226,238,.62)", rail: ["#69747f", "#b9c3cd", "#4b555f"], base: ["#3a4653", "#1d262f"],
  label: "#10161d", shadow: "rgba(0,0,0,.62)",
  ball: [[0, "#eef4fa"], [0.32, "#aebccb"], [0.5, "#6f7f90"], [0.56, "#c2ccd6"], [0.72, "#93a1af"], [1, "#3c4753"]],
  rim: "rgba(8,14,22,.62)",
  glowMode: "lighter", glow: (strength) =>
  `rgba(255, ${Math.round(140 + 90 * strength)}, ${Math.round(40 + 120 * strength)}, ${strength})`,
  lens: "#131b24", lensLine: "rgba(210,224,238,.75)", lensBall: ["#dfe8f1", "#56636f"], patch: "#fff3d6",
  energies: ["#6fb6f2", "#8d9db0", "#ffb54a"],
};

export const DAY = {
  dark: false, back: "#f6f4ef", ink: "#17202a", accent: "#a85a00", focus: "#0b5c9e", grid: "rgba(0,0,0,.16)",
  spike: "#c05a00",
  string: "rgba(60,72,84,.6)", rail: ["#8b96a1", "#d5dce3", "#66717c"], base: ["#8a6a4c", "#5f452e"], label: "#10161d",
  shadow: "rgba(40,50,60,.34)",
  ball: [[0, "#ffffff"], [0.32, "#d3dbe3"], [0.5, "#98a5b2"], [0.56, "#dde3e9"], [0.72, "#b4bec8"], [1, "#66727e"]],
  rim: "rgba(30,40,52,.5)",
  glowMode: "source-over", glow: (strength) => `rgba(240, ${Math.round(95 + 60 * strength)}, 20, ${0.85 * strength})`,
  lens: "#ffffff", lensLine: "rgba(50,62,74,.75)", lensBall: ["#76838f", "#b4bec8"], patch: "#ff9d2e",
  energies: ["#4d97d6", "#9aa6b3", "#e08a1e"],
};
