// A sound for each click: louder for a larger impulse, higher for shorter contacts.

const FULL_SPEED = 1.2;   // m/s: the change of a ball's speed that is as loud as it gets
const LENGTH = 0.09;      // s
const PITCH = 2400;       // Hz, of the sound that is kept

export class Sound {
  constructor() { this.on = false; this.played = 0; }

  /** Browsers allow sound only after a touch. */
  switchOn(on) {
    this.on = on;
    if (!on || this.context) return void this.context?.resume();
    this.context = new AudioContext();
    const rate = this.context.sampleRate;
    this.buffer = this.context.createBuffer(1, LENGTH * rate, rate);
    this.buffer.getChannelData(0).forEach((_, i, samples) => {
      const t = i / rate, ring = (f, decay) => Math.sin(2 * Math.PI * f * t) * Math.exp(-t * decay);
      samples[i] = 0.5 * ring(PITCH, 90) + 0.3 * ring(2.76 * PITCH, 160) + 0.2 * ring(5.4 * PITCH, 320);
    });
  }

  /** The pulses that have finished since the last picture, of balls of this mass (kg). */
  click(pulses, mass) {
    if (!this.on || !this.context || !pulses.length) return;
    const strongest = pulses.reduce((a, b) => (b.impulse > a.impulse ? b : a));
    const loudness = Math.min(1, strongest.impulse / mass / FULL_SPEED) ** 0.8;
    if (loudness < 0.003) return;
    const duration = Math.max(strongest.release - strongest.onset, 1e-6), { context, buffer } = this;
    const playbackRate = Math.max(0.35, Math.min(1.6, (2.5e-5 / duration) ** 0.25));
    const source = new AudioBufferSourceNode(context, { buffer, playbackRate });
    source.connect(new GainNode(context, { gain: 0.6 * loudness })).connect(context.destination);
    source.start();
    this.played++;
  }
}
