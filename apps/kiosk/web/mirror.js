// SPDX-License-Identifier: Apache-2.0
// What the camera sees, as in a mirror: the small grey picture with the joints over it, and in red what is wrong.
'use strict';

const kArmJoints = {L: ['LS', 'LE', 'LA'], R: ['RS', 'RE', 'RA']};
const kWrong = '#ff5a4d';

class Mirror {
  constructor(canvas) {
    this.canvas = canvas;
    this.bones = [];
    this.names = [];
    this.clear();
  }
  setBones(bones, names) {
    this.bones = bones;
    this.names = names;
  }
  clear() {
    this.picture = null;
    this.pixels = null;
    this.code = '';
    this.loading = false;
    this.request = (this.request || 0) + 1;
    this.draw();
  }
  // One at a time: a slow network shows fewer, not older ones.
  load(number) {
    if (this.loading) return;
    this.loading = true;
    const request = this.request;
    const image = new Image();
    image.onload = image.onerror = (event) => {
      if (request !== this.request) return;
      this.loading = false;
      if (event.type !== 'load') return;
      this.picture = image;
      this.draw();
    };
    image.src = `/picture.png?${number}`;
  }
  setJoints(pixels, code) {
    this.pixels = pixels || null;
    this.code = code;
    this.draw();
  }
  isWrong(joint) {
    const name = this.names[joint] || '';
    if (!this.code.startsWith('ARMS_CLOSE')) return false;
    const sides = this.code === 'ARMS_CLOSE' ? ['L', 'R'] : [this.code === 'ARMS_CLOSE_LEFT' ? 'L' : 'R'];
    return sides.some((side) => kArmJoints[side].includes(name));
  }
  draw() {
    const context = this.canvas.getContext('2d');
    if (!this.picture) {
      context.clearRect(0, 0, this.canvas.width, this.canvas.height);
      return;
    }
    const scale = 3;  // lines are finer than the picture
    const width = this.picture.naturalWidth * scale, height = this.picture.naturalHeight * scale;
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    context.drawImage(this.picture, 0, 0, width, height);
    if (this.pixels) this.drawBones(context, width, height);
    this.drawEdges(context, width, height);
  }
  drawBones(context, width, height) {
    context.lineCap = 'round';
    for (const [from, to, like] of this.bones) {
      const wrong = this.isWrong(from) && this.isWrong(to);
      const side = (this.names[like] || '')[0];
      context.strokeStyle = wrong ? kWrong : {L: '#f0a050', R: '#c08af0'}[side] || '#5cc8f0';
      context.lineWidth = height * (wrong ? 0.025 : 0.010);
      context.beginPath();
      for (const joint of [from, to]) {
        const [x, y] = this.pixels[joint];
        context.lineTo(x * width / 1000, y * height / 1000);
      }
      context.stroke();
    }
  }
  drawEdges(context, width, height) {
    const thick = height * 0.03;
    context.fillStyle = kWrong;
    if (this.code === 'HEAD_CUT') context.fillRect(0, 0, width, thick);
    if (this.code === 'FEET_CUT') context.fillRect(0, height - thick, width, thick);
    if (this.code === 'SIDE_CUT') {
      context.fillRect(0, 0, thick, height);
      context.fillRect(width - thick, 0, thick, height);
    }
  }
}
