// SPDX-License-Identifier: Apache-2.0
// Tones for what the page says: who shows their back cannot read. Tones and not speech: the browser's own voices differ
// from machine to machine and many need a network, recorded ones in five languages would be larger than the program.
'use strict';

// [hertz, milliseconds] one after the other; 0 Hz is a pause. Rising: come, go on; falling: back; two alike: stand still.
const kTones = {
  NO_PERSON: [[392, 150], [523, 150]],
  TURN_ROUND: [[523, 150], [659, 150], [523, 150], [659, 150]],
  TURN_ON: [[523, 120], [587, 120], [659, 120], [784, 200]],
  WALK_ROUND: [[523, 120], [659, 120], [523, 120], [659, 200]],
  TURN_SLOWER: [[659, 250], [0, 80], [523, 400]],
  QUARTER: [[784, 120]],
  SEVERAL_PEOPLE: [[330, 120], [0, 60], [330, 120], [0, 60], [330, 120]],
  STEP_TO_THE_MIDDLE: [[392, 120], [523, 120], [392, 120]],
  DEPTH_MISSING: [[330, 250], [0, 80], [294, 250]],
  TOO_NEAR: [[523, 150], [392, 250]],
  TOO_FAR: [[392, 150], [523, 250]],
  HEAD_CUT: [[784, 120], [784, 120], [392, 250]],
  FEET_CUT: [[262, 120], [262, 120], [523, 250]],
  SIDE_CUT: [[440, 120], [349, 120], [440, 120]],
  CALIBRATION_POSE: [[392, 120], [494, 120], [587, 120]],
  NOT_FRONTAL: [[494, 200], [440, 200]],
  NOT_UPRIGHT: [[440, 120], [494, 120], [523, 200]],
  ARMS_CLOSE: [[587, 120], [440, 120], [587, 120]],
  ARMS_CLOSE_LEFT: [[587, 120], [440, 120], [440, 120]],
  ARMS_CLOSE_RIGHT: [[440, 120], [440, 120], [587, 120]],
  MOVING: [[294, 250], [0, 100], [294, 250]],
  TOO_NOISY: [[233, 400]],
  CLOTHED: [[349, 200], [330, 200]],
  OUT_OF_POPULATION: [[330, 200], [262, 300]],
  FLOOR_BENT: [[262, 200], [220, 200], [262, 200]],
  FEET_RAISED: [[523, 120], [440, 120], [349, 250]],
  HEAD_UNSEEN: [[784, 120], [659, 120], [784, 120]],
  HOLD: [[659, 90]],
  WORKING: [[659, 90], [0, 60], [659, 90]],
  DONE: [[523, 140], [659, 140], [784, 300]],
  CAMERA_LOST: [[262, 250], [208, 400]],
  NO_CAMERA: [[208, 250], [208, 400]],
  MODELS_MISSING: [[196, 250], [208, 400]],
  SERVER_GONE: [[220, 250], [175, 400]],
};
const kRepeatMs = 4000;  // a wish that lasts is said again

class Sounds {
  constructor() {
    this.on = true;
    this.context = null;
    this.played = [];  // codes, for who looks into it
    this.last = null;
    this.lastAt = 0;
  }
  // Browsers start sound with a touch only.
  unlock() {
    if (!this.context && window.AudioContext) this.context = new AudioContext();
    if (this.context && this.context.state === 'suspended') this.context.resume();
  }
  // What is said now; a silent code ends what was said before.
  say(code, now = Date.now()) {
    if (code === this.last && now - this.lastAt < kRepeatMs) return;
    const again = code === this.last;
    this.last = code;
    this.lastAt = now;
    if (!this.on || !kTones[code] || (again && (code === 'DONE' || code === 'SERVER_GONE'))) return;
    this.played.push(code);
    if (this.played.length > 100) this.played.shift();
    this.play(kTones[code]);
  }
  // Once, beside what is said.
  mark(code) {
    if (!this.on) return;
    this.played.push(code);
    if (this.played.length > 100) this.played.shift();
    this.play(kTones[code]);
  }
  play(tones) {
    if (!this.context || this.context.state !== 'running') return;
    let at = this.context.currentTime + 0.02;
    for (const [hertz, ms] of tones) {
      if (hertz) this.tone(hertz, at, ms / 1000);
      at += ms / 1000;
    }
  }
  // Without a ramp a tone begins and ends with a crack.
  tone(hertz, at, length) {
    const oscillator = this.context.createOscillator();
    const gain = this.context.createGain();
    oscillator.frequency.value = hertz;
    gain.gain.setValueAtTime(0, at);
    gain.gain.linearRampToValueAtTime(0.3, at + 0.015);
    gain.gain.setValueAtTime(0.3, at + length - 0.03);
    gain.gain.linearRampToValueAtTime(0, at + length - 0.005);
    oscillator.connect(gain).connect(this.context.destination);
    oscillator.start(at);
    oscillator.stop(at + length);
  }
}
