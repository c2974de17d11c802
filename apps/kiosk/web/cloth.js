// SPDX-License-Identifier: Apache-2.0
// Clothes of an avatar that move: what /cloth.bin says of a rough mesh, added to the vertices of the fine one before
// they are skinned (docs/garments.md).
'use strict';

const kClothGlideMs = [60, 250];  // least and most
const kClothBlock = 16, kClothStepM = 0.125e-3;  // garment/drape/offset_wire.h

// Of each garment x, y, z of each rough vertex, metres.
function readCloth(buffer) {
  const view = new DataView(buffer), bytes = new Int8Array(buffer), garments = [];
  if (view.getUint32(0) !== 0x696d3263) throw new Error('not offsets of cloth');  // "im2c"
  let at = 12;
  for (let g = view.getUint32(8, true); g > 0; --g) {
    const count = view.getUint32(at, true), offsets = new Float32Array(3 * count);
    at += 4;
    for (let i = 0; i < offsets.length;) {
      const step = kClothStepM * 2 ** bytes[at++];
      for (const end = Math.min(offsets.length, i + 3 * kClothBlock); i < end;) offsets[i++] = step * bytes[at++];
    }
    garments.push(offsets);
  }
  return {number: view.getUint32(4, true), garments};
}

class MovingCloth {
  // An avatar of /tryon.glb; one whose cloth names no rough vertices has no garments here.
  constructor(avatar) {
    this.garments = [];
    this.number = this.since = 0;
    this.arrived = true;
    avatar.traverse((o) => {
      const geometry = o.geometry;
      if (!geometry || !geometry.attributes._corners || !geometry.attributes._shares) return;
      this.garments.push({geometry, rest: Float32Array.from(geometry.attributes.position.array),
                          corners: geometry.attributes._corners.array, shares: geometry.attributes._shares.array,
                          from: null, to: null, shown: null});
      for (const name of ['_corners', '_shares']) geometry.deleteAttribute(name);  // no shader has a use for them
    });
  }

  // Shown over the time to the next frame, as far as the last two tell how long that is.
  set({number, garments}, now) {
    if (garments.length !== this.garments.length) return;
    this.number = number;
    this.lasts = Math.min(kClothGlideMs[1], Math.max(kClothGlideMs[0], now - this.since));
    this.since = now;
    this.arrived = false;
    this.garments.forEach((g, i) => {
      g.to = garments[i];
      g.from = g.shown ? g.shown.slice() : new Float32Array(g.to.length);
      if (!g.shown) g.shown = new Float32Array(g.to.length);
    });
  }

  // Whether there is more to show after this. `still`: at once what was set last.
  advance(now, still) {
    if (this.arrived) return false;
    const share = still ? 1 : Math.min(1, (now - this.since) / this.lasts);
    for (const g of this.garments) {
      for (let i = 0; i < g.shown.length; ++i) g.shown[i] = g.from[i] + share * (g.to[i] - g.from[i]);
      this.place(g);
    }
    this.arrived = share === 1;
    return !this.arrived;
  }

  place({geometry, rest, corners, shares, shown}) {
    const places = geometry.attributes.position.array;
    for (let v = 0; 3 * v < places.length; ++v) {
      let x = rest[3 * v], y = rest[3 * v + 1], z = rest[3 * v + 2];
      for (let k = 0; k < 3; ++k) {
        const share = shares[3 * v + k], at = 3 * corners[4 * v + k];
        x += share * shown[at];
        y += share * shown[at + 1];
        z += share * shown[at + 2];
      }
      places[3 * v] = x;
      places[3 * v + 1] = y;
      places[3 * v + 2] = z;
    }
    geometry.attributes.position.needsUpdate = true;
    geometry.computeVertexNormals();
  }
}

// Asks for what moves while an avatar of that query is on the stage: a frame when the program says there is one, and
// every second a word that a page shows it.
class ClothLink {
  constructor() { this.query = ''; }

  begin(query) {
    this.end();
    if (!stage || !stage.cloth || stage.cloth.garments.length === 0) return;
    this.query = query;
    this.fetch();
    this.timer = setInterval(() => this.fetch('HEAD'), 1000);
  }
  end() {
    clearInterval(this.timer);
    this.query = '';
    this.asking = false;
  }

  // One at a time: a slow network shows fewer, not older ones.
  async fetch(method = 'GET') {
    const query = this.query;
    if (!query || (method === 'GET' && this.asking)) return;
    if (method === 'GET') this.asking = true;
    try {
      const answer = await fetch(`/cloth.bin?${query}`, {method});
      if (query !== this.query) return;
      if (answer.status === 404 || answer.status === 409) this.end();  // no one is here, or others' clothes move
      if (method !== 'GET' || answer.status !== 200) return;
      const frame = readCloth(await answer.arrayBuffer());
      if (query !== this.query || !stage.cloth) return;
      stage.cloth.set(frame, performance.now());
      stage.requestDraw();
    } catch (error) {
      // The program has ended, and the stream says so; or the next frame comes.
    } finally {
      if (method === 'GET' && query === this.query) this.asking = false;
    }
  }
}
const clothLink = new ClothLink();
document.addEventListener('im2fit-forget', () => clothLink.end());
