// The engine's part of each picture without a browser, in processor time, so that what else the machine does counts little:
// node --single-threaded web/node.mjs PAGE BALLS [SECONDS] < web/frames.mjs
//
// As in the page: two balls are lifted, the contact is changed every second, and the clock moves on by a sixtieth of a second.

const balls = Number(process.argv[3]), seconds = Number(process.argv[4] ?? 120);
const WARM = 20; // s, in which the engine is compiled for good
const processor = () => {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1000;
};
const source = new Live(engine, new Setup(balls, TABLE).with({ x_start: [-0.1, -0.1] })), clock = new Clock();
const laws = ["linear", "hertz", "quadratic", "rigid", "cubic"], spent = [];
for (let second = 0; second < seconds; second++) {
  for (let picture = 0; picture < 60; picture++) {
    const begun = processor();
    clock.frame(1 / 60, [source]);
    if (second >= WARM) spent.push(processor() - begun);
    source.takePulses();
    // What is left of the sixtieth of a second: time for the garbage collector.
    await new Promise((resolve) => setImmediate(resolve));
  }
  source.change(LAWS[laws[second % laws.length]]);
}
spent.sort((a, b) => a - b);
const at = (part) => spent[Math.min(spent.length - 1, Math.floor(part * spent.length))].toFixed(2);
console.log(
  `${balls} balls, engine in processor time, ms a picture: mean ${(spent.reduce((a, b) => a + b) / spent.length).toFixed(3)}, ` +
    `50 % ${at(0.5)}, 99 % ${at(0.99)}, 99.9 % ${at(0.999)}, most ${at(1)}; ${(100 * source.time / seconds).toFixed(1)} % of the time passed`,
);
