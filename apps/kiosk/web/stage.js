// SPDX-License-Identifier: Apache-2.0
// The 3D view: the dressed body of who was measured, which follows them. Metres, +y up, floor at y = 0, the camera that
// measures in the direction of +z.
'use strict';

const kShare = 0.88;       // of the view's height that the body has
const kSharePair = 0.74;   // of two, between the switches and their verdicts
const kElbowRoomM = 0.95;  // that has to be in view across, with the arms
const kApartM = 0.92;      // two bodies, from middle to middle

const kBodyMaterials = ['skin', 'eyes', 'hair'];
const kOverUnits = 1200;   // of the depth buffer: 12 mm at 4 m

// Clothes that move may stand out of those over them, by some millimetres at a hem. What is worn over others is drawn
// as if it were so much nearer.
function layClothes(body) {
  let clothes = 0;
  body.traverse((o) => {
    if (!o.material || kBodyMaterials.includes(o.material.name) || ++clothes < 2) return;
    o.material.polygonOffset = true;
    o.material.polygonOffsetUnits = -kOverUnits;
  });
}

class Stage {
  // Throws where the browser has no WebGL.
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.gammaOutput = true;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.1, 30);
    this.camera.position.set(0.9, 1.25, 3.9);
    this.orbit = new THREE.OrbitControls(this.camera, canvas);
    this.orbit.target.set(0, 0.92, 0);
    this.orbit.minDistance = 1;
    this.orbit.maxDistance = 8;
    this.orbit.addEventListener('change', () => this.requestDraw());
    this.orbit.update();
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 0.6));
    const sun = new THREE.DirectionalLight(0xffffff, 0.7);
    sun.position.set(1.5, 3, 2.5);
    this.scene.add(sun);
    const grid = new THREE.GridHelper(4, 16, 0x8a8f98, 0x8a8f98);
    grid.material.transparent = true;
    grid.material.opacity = 0.35;
    this.scene.add(grid);
    this.heightM = 0;  // of the body in view; 0: not yet framed
    this.avatar = null;
    this.cloth = null;  // of the avatar, where it moves
    this.avatarsRequested = 0;
    this.beside = null;  // {avatar, nodes}: the same body in another size, beside the avatar
    this.besidesRequested = 0;
    this.avatarLeft = true;
    this.nodes = [];
    this.wanted = null;
    this.drawRequested = false;
    this.still = window.matchMedia('(prefers-reduced-motion: reduce)');
    new ResizeObserver(() => this.requestDraw()).observe(canvas);
    this.requestDraw();
  }

  // Resolves to whether it is on the stage: not when another was requested, or none, meanwhile.
  loadAvatar(url, segments) {
    const request = ++this.avatarsRequested;
    return new Promise((resolve, reject) => new THREE.GLTFLoader().load(url, (gltf) => {
      if (request !== this.avatarsRequested) {
        resolve(false);
        return;
      }
      this.stand(gltf.scene, segments);
      resolve(true);
    }, undefined, reject));
  }

  // The same body once more, to the other side of the avatar; `avatarLeft`: which side that is on. As loadAvatar.
  loadBeside(url, segments, avatarLeft) {
    const request = ++this.besidesRequested;
    return new Promise((resolve, reject) => new THREE.GLTFLoader().load(url, (gltf) => {
      if (request !== this.besidesRequested || !this.avatar) {
        resolve(false);
        return;
      }
      this.standBeside(gltf.scene, segments, avatarLeft);
      resolve(true);
    }, undefined, reject));
  }

  standBeside(body, segments, avatarLeft) {
    if (!this.beside) this.faceFront();
    this.removeBeside();
    body.traverse((o) => { o.frustumCulled = false; });
    layClothes(body);
    this.beside = {avatar: body, nodes: segments.map((name) => body.getObjectByName(name))};
    this.avatarLeft = avatarLeft;
    this.scene.add(body);
    this.place();
  }

  // Of two bodies neither is to look larger for being nearer, nor to hide the other.
  faceFront() {
    const {target} = this.orbit, away = this.camera.position.clone().sub(target);
    this.camera.position.set(target.x, target.y + away.y, target.z + Math.hypot(away.x, away.z));
    this.orbit.update();
  }

  removeBeside() {
    ++this.besidesRequested;
    if (!this.beside) return;
    this.discard(this.beside.avatar);
    this.beside = null;
    this.place();
  }

  // Where they stand, and as far away as both need.
  place() {
    const half = this.beside ? (this.avatarLeft ? -kApartM : kApartM) / 2 : 0;
    if (this.avatar) this.avatar.position.x = half;
    if (this.beside) this.beside.avatar.position.x = -half;
    this.frame(this.heightM);
    this.requestDraw();
  }

  discard(body) {
    this.scene.remove(body);
    body.traverse((o) => {
      if (o.geometry) o.geometry.dispose();
      if (o.material && o.material.map) o.material.map.dispose();
      if (o.material) o.material.dispose();
    });
  }

  stand(body, segments) {
    const beside = this.beside;
    this.beside = null;  // it stays when its neighbour changes clothes
    this.removeAvatar();
    this.beside = beside;
    this.avatar = body;
    this.avatar.traverse((o) => { o.frustumCulled = false; });  // bones move it out of the box it was made in
    this.nodes = segments.map((name) => this.avatar.getObjectByName(name));
    this.cloth = new MovingCloth(this.avatar);
    layClothes(this.avatar);
    this.scene.add(this.avatar);
    const box = new THREE.Box3().setFromObject(this.avatar);
    const heightM = box.max.y - box.min.y;
    // Other clothes on the same body leave the view as the person has turned it.
    if (Math.abs(heightM - this.heightM) > 0.02) this.frame(heightM);
    if (this.beside) this.place();
    this.requestDraw();
  }

  // From where it looks, so far that the body fills the view.
  frame(heightM) {
    this.heightM = heightM;
    if (!(heightM > 0)) return;
    const slope = Math.tan(this.camera.fov / 2 * Math.PI / 180);
    const distance = Math.max(heightM / (this.beside ? kSharePair : kShare), (kElbowRoomM + (this.beside ? kApartM : 0)) / this.camera.aspect) / (2 * slope);
    const from = this.camera.position.clone().sub(this.orbit.target).setLength(distance);
    this.orbit.target.y = heightM / 2;
    this.camera.position.copy(this.orbit.target).add(from);
    this.orbit.update();
  }

  removeAvatar() {
    ++this.avatarsRequested;
    this.removeBeside();
    if (!this.avatar) return;
    this.discard(this.avatar);
    this.avatar = null;
    this.cloth = null;
    this.nodes = [];
    this.wanted = null;
    this.requestDraw();
  }

  // `root` and the rotation of each segment relative to its parent, as the .glb's nodes have them.
  pose(root, rotations) {
    if (!this.avatar) return;
    this.wanted = {root: new THREE.Vector3(...root), rotations: rotations.map((q) => new THREE.Quaternion(...q))};
    this.requestDraw();
  }

  requestDraw() {
    if (this.drawRequested) return;
    this.drawRequested = true;
    requestAnimationFrame(() => { this.drawRequested = false; this.draw(); });
  }

  // Frames come thirty times a second at most; in between the body glides.
  glide() {
    if (!this.wanted) return;
    const share = this.still.matches ? 1 : 0.35;
    this.nodes[0].position.lerp(this.wanted.root, share);
    // The view goes along, so that nobody walks out of it.
    const {x, z} = this.nodes[0].position, target = this.orbit.target;
    const along = new THREE.Vector3(x - target.x, 0, z - target.z);
    target.add(along);
    this.camera.position.add(along);
    let left = this.nodes[0].position.distanceTo(this.wanted.root);
    this.wanted.rotations.forEach((q, i) => {
      this.nodes[i].quaternion.slerp(q, share);
      left = Math.max(left, 1 - Math.abs(this.nodes[i].quaternion.dot(q)));
    });
    if (left > 1e-5) this.requestDraw();
  }

  draw() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (!width || !height) return;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== width || size.y !== height) {
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.frame(this.heightM);
    }
    this.glide();
    if (this.beside && this.avatar) {
      this.beside.nodes.forEach((node, i) => {
        node.quaternion.copy(this.nodes[i].quaternion);
        if (i === 0) node.position.copy(this.nodes[0].position);
      });
      // Seen from behind the left one is the right one.
      const x = (body) => body.getWorldPosition(new THREE.Vector3()).project(this.camera).x;
      this.camera.updateMatrixWorld();
      document.body.dataset.swapped = String(x(this.avatar) > x(this.beside.avatar) === this.avatarLeft);
    }
    if (this.cloth && this.cloth.advance(performance.now(), this.still.matches)) this.requestDraw();
    this.renderer.render(this.scene, this.camera);
  }
}
