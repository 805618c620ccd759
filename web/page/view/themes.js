// Colours of night and day that are drawn with; those of the page are in style.css.

export const NIGHT = {
  dark: true, back: "#0f141a", ink: "#eaf0f6", soft: "#a9b6c4", accent: "#ffb54a", focus: "#7cc4ff",
  grid: "rgba(255,255,255,.14)",
  string: "rgba(214,226,238,.62)", rail: ["#4b555f", "#7e8994", "#b9c3cd"], base: ["#3a4653", "#1d262f"],
  label: "#10161d", shadow: "rgba(0,0,0,.62)",
  ball: [[0, "#eef4fa"], [0.32, "#aebccb"], [0.5, "#6f7f90"], [0.56, "#c2ccd6"], [0.72, "#93a1af"], [1, "#3c4753"]],
  rim: "rgba(8,14,22,.62)",
  glowMode: "lighter", glow: (strength) =>
  `rgba(255, ${Math.round(140 + 90 * strength)}, ${Math.round(40 + 120 * strength)}, ${strength})`,
  lens: "#131b24", lensLine: "rgba(210,224,238,.75)", lensBall: ["#dfe8f1", "#56636f"], patch: "#fff3d6",
  energies: ["#6fb6f2", "#8d9db0", "#ffb54a"],
  halo: "#e8f0f8",
  // For steel.js, as light: zenith, horizon, lamp, windows, table and its shadow; top of the base and its grain, its
  // side; strings; glow.
  space: [[0.04, 0.06, 0.085], [0.32, 0.4, 0.5], [2.2, 2.35, 2.6], [1, 1.1, 1.25], [0.04, 0.055, 0.075, 0.6],
    [0.035, 0.055, 0.08], [0.02, 0.03, 0.045], [0.45, 0.5, 0.56], [1, 0.5, 0.12]],
};

export const DAY = {
  dark: false, back: "#f6f4ef", ink: "#17202a", soft: "#4a5866", accent: "#9e5300", focus: "#0b5c9e",
  grid: "rgba(0,0,0,.16)",
  string: "rgba(60,72,84,.6)", rail: ["#66717c", "#9ca7b1", "#d5dce3"], base: ["#8a6a4c", "#5f452e"], label: "#10161d",
  shadow: "rgba(40,50,60,.34)",
  ball: [[0, "#ffffff"], [0.32, "#d3dbe3"], [0.5, "#98a5b2"], [0.56, "#dde3e9"], [0.72, "#b4bec8"], [1, "#66727e"]],
  rim: "rgba(30,40,52,.5)",
  glowMode: "source-over", glow: (strength) => `rgba(240, ${Math.round(95 + 60 * strength)}, 20, ${0.85 * strength})`,
  lens: "#ffffff", lensLine: "rgba(50,62,74,.75)", lensBall: ["#76838f", "#b4bec8"], patch: "#ff9d2e",
  energies: ["#4d97d6", "#9aa6b3", "#e08a1e"],
  halo: "#ffffff",
  space: [[0.36, 0.42, 0.48], [0.8, 0.83, 0.86], [1.3, 1.3, 1.3], [0.9, 0.9, 0.9], [0.6, 0.58, 0.55, 0.38],
    [0.3, 0.16, 0.075, 0.18], [0.13, 0.065, 0.03], [0.1, 0.12, 0.15], [0.95, 0.25, 0.02]],
};
